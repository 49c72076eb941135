# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Planar transforms, placements and angles; ``T_a_b`` maps coordinates in ``b`` to ``a``."""

from fpnet_core.geometry.angles import angle_between, rotation, wrap_to_pi
from fpnet_core.geometry.placements import Placement, Placements
from fpnet_core.geometry.polar import scale_of
from fpnet_core.geometry.transforms import SE2, Affine2D, Similarity2D

__all__ = [
    'SE2',
    'Affine2D',
    'Placement',
    'Placements',
    'Similarity2D',
    'angle_between',
    'rotation',
    'scale_of',
    'wrap_to_pi',
]
