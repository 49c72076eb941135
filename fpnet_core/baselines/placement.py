# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the baseline localizers answer."""

from __future__ import annotations

from dataclasses import dataclass

from fpnet_core.geometry import Affine2D


@dataclass(frozen=True, eq=False)
class Placement:
    """
    Where a baseline puts the submap, and whether it stands for that.

    ``A_plan_submap`` maps submap metres to the plan's nominal ones; ``score`` in [0, 1] is the
    method's own confidence.
    """

    A_plan_submap: Affine2D
    score: float
    is_claimed: bool
