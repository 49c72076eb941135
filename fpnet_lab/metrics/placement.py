# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
How far a placement of the submap is from the truth: the paper's measures and metric ones.

The paper's transform score (TS) and AUC compare translation *vectors* by their angle, so they
depend on where both frames have their origins; they are kept for comparison with its tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fpnet_core.geometry import Affine2D, angle_between

TS_ROTATION = 0.08
"""Given by the paper: greatest Frobenius norm of ``R_1^T R_2 - I`` (about 3.2 degrees)."""

TS_SCALE = 0.07
"""Given by the paper: greatest relative error of the scale."""

TS_DIRECTION_RAD = float(np.deg2rad(20.0))
"""Given by the paper: greatest angle between the translation vectors, folded at 90 degrees."""

AUC_DEGREES = (1, 10, 20)
"""Given by the paper: limits of the cumulative curves."""

RIGHT_DEG, RIGHT_SCALE, RIGHT_DIAGONALS = 5.0, 0.1, 0.03
"""
A placement is right within these: rotation, scale, and share of the plan's diagonal; the paper's
direction says nothing where both frames begin anywhere. Chosen.
"""


@dataclass(frozen=True)
class PlacementError:
    """
    One estimate against the truth; infinite where there is no estimate.

    ``rotation_deg`` and ``scale`` (relative) compare the similarity parts, ``direction_deg`` the
    translation vectors, ``distance_m`` is that of the submap's middle in the plan's metres.
    """

    rotation_deg: float = np.inf
    scale: float = np.inf
    direction_deg: float = np.inf
    distance_m: float = np.inf

    @property
    def is_transform_right(self) -> bool:
        """Tell whether the paper counts the transform as right (TS)."""
        rotation = 2.0 * np.sqrt(2.0) * abs(np.sin(np.deg2rad(min(self.rotation_deg, 180.0)) / 2))
        return bool(
            rotation < TS_ROTATION
            and self.scale < TS_SCALE
            and np.deg2rad(self.direction_deg) < TS_DIRECTION_RAD
        )

    def is_right(self, diagonal_m: float) -> bool:
        """Tell whether it is right on a plan with such a diagonal."""
        is_near = self.is_within(RIGHT_DIAGONALS * diagonal_m, RIGHT_DEG)
        return is_near and self.scale <= RIGHT_SCALE

    def is_within(self, distance_m: float, rotation_deg: float) -> bool:
        """Tell whether the submap's middle and heading are this near."""
        return self.distance_m <= distance_m and self.rotation_deg <= rotation_deg


def placement_error(
    estimate: Affine2D | None, truth: Affine2D, middle: tuple[float, float]
) -> PlacementError:
    """Compare ``estimate`` with ``truth``, both submap to plan, at the submap's ``middle`` [m]."""
    if estimate is None:
        return PlacementError()
    moved = estimate.apply(np.array(middle)) - truth.apply(np.array(middle))
    return PlacementError(
        rotation_deg=float(np.degrees(angle_between(estimate.heading, truth.heading))),
        scale=abs(estimate.scale / truth.scale - 1.0),
        direction_deg=_folded_angle_deg(estimate, truth),
        distance_m=float(np.linalg.norm(moved)),
    )


def auc(errors: Sequence[PlacementError], limit_deg: float) -> float:
    """
    Return the area under the cumulative error curve up to ``limit_deg``, 0 to 1.

    The error is the greater one of the rotation and of the angle between the translation vectors;
    a missing estimate has an infinite one. 0 without errors.
    """
    if not errors:
        return 0.0
    worst = np.array([max(error.rotation_deg, error.direction_deg) for error in errors])
    # Every error e below the limit lifts the curve by 1 / n from e on.
    return float(np.clip(1.0 - worst / limit_deg, 0.0, None).sum() / len(worst))


def _folded_angle_deg(estimate: Affine2D, truth: Affine2D) -> float:
    a, b = estimate.translation, truth.translation
    across = abs(a[0] * b[1] - a[1] * b[0])
    return float(np.degrees(np.arctan2(across, abs(float(a @ b)))))
