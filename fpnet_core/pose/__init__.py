# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From region matches to verified placements: propose, reject early, refine, verify."""

from fpnet_core.pose.estimate import (
    aligned_placements,
    compared_at,
    select_promising,
)
from fpnet_core.pose.evidence import MapEvidence, PreparedMap, map_evidence
from fpnet_core.pose.hypotheses import propose
from fpnet_core.pose.refine import (
    AGAIN,
    FINE,
    RIGID_STRAIN,
    ROUGH,
    AlignmentPrior,
    SolverSchedule,
    refine,
)
from fpnet_core.pose.verify import WallAgreement, agreement, coarse_support, wall_support

__all__ = [
    'AGAIN',
    'FINE',
    'RIGID_STRAIN',
    'ROUGH',
    'AlignmentPrior',
    'MapEvidence',
    'PreparedMap',
    'SolverSchedule',
    'WallAgreement',
    'agreement',
    'aligned_placements',
    'coarse_support',
    'compared_at',
    'map_evidence',
    'propose',
    'refine',
    'select_promising',
    'wall_support',
]
