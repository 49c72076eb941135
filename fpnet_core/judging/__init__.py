# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From placements and evidence to probabilities and reasons: one learned judge."""

from fpnet_core.judging.evidence import CONTEXT, FIGURES, Evidence, gather_evidence
from fpnet_core.judging.judge import ALONE, WORD, Judge, Verdict, configured_model
from fpnet_core.judging.model import JUDGE_NAME, JUDGE_SCHEMA, JudgeModel, read_judge
from fpnet_core.judging.reasons import Circumstances, reason_of

__all__ = [
    'ALONE',
    'CONTEXT',
    'FIGURES',
    'JUDGE_NAME',
    'JUDGE_SCHEMA',
    'WORD',
    'Circumstances',
    'Evidence',
    'Judge',
    'JudgeModel',
    'Verdict',
    'configured_model',
    'gather_evidence',
    'read_judge',
    'reason_of',
]
