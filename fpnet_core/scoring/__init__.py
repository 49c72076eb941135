# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Learned placement scorer: from placements and evidence to probabilities and reasons."""

from fpnet_core.scoring.evidence import CONTEXT, FIGURES, Evidence, gather_evidence
from fpnet_core.scoring.model import SCORER_NAME, SCORER_SCHEMA, PlacementModel, read_scorer
from fpnet_core.scoring.reasons import Circumstances, reason_of
from fpnet_core.scoring.scorer import ALONE, WORD, PlacementScorer, Posterior, configured_model

__all__ = [
    'ALONE',
    'CONTEXT',
    'FIGURES',
    'SCORER_NAME',
    'SCORER_SCHEMA',
    'WORD',
    'Circumstances',
    'Evidence',
    'PlacementModel',
    'PlacementScorer',
    'Posterior',
    'configured_model',
    'gather_evidence',
    'read_scorer',
    'reason_of',
]
