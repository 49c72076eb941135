# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Errors of a submap placement: the paper's measures and metric ones.

The paper's transform score (TS) and AUC compare translation *vectors* by their angle, so they
depend on the origins of both frames; they are kept for comparison with the paper's tables.
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
Limits of a right placement: rotation, scale, and distance as a share of the plan's diagonal. The
paper's direction is not used: it has no meaning where the frame origins are arbitrary. Chosen.
"""


@dataclass(frozen=True)
class PlacementError:
    """
    Error of one estimate; infinite without an estimate.

    ``rotation_deg`` and ``scale`` (relative) compare the similarity parts, ``direction_deg`` the
    translation vectors; ``distance_m`` is the error at the submap's centre, in plan metres.
    """

    rotation_deg: float = np.inf
    scale: float = np.inf
    direction_deg: float = np.inf
    distance_m: float = np.inf

    @property
    def is_transform_right(self) -> bool:
        """Return whether the paper counts the transform as right (TS)."""
        rotation = 2.0 * np.sqrt(2.0) * abs(np.sin(np.deg2rad(min(self.rotation_deg, 180.0)) / 2))
        return bool(
            rotation < TS_ROTATION
            and self.scale < TS_SCALE
            and np.deg2rad(self.direction_deg) < TS_DIRECTION_RAD
        )

    def is_right(self, diagonal_m: float) -> bool:
        """Return whether the placement is right on a plan with this diagonal."""
        is_near = self.is_within(RIGHT_DIAGONALS * diagonal_m, RIGHT_DEG)
        return is_near and self.scale <= RIGHT_SCALE

    def is_within(self, distance_m: float, rotation_deg: float) -> bool:
        """Return whether position error at the submap's centre and heading error are in limits."""
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

    The error is the larger of the rotation and the angle between the translation vectors; it is
    infinite without an estimate. Returns 0 without errors.
    """
    if not errors:
        return 0.0
    worst = np.array([max(error.rotation_deg, error.direction_deg) for error in errors])
    # Every error e below the limit raises the curve by 1 / n from e on.
    return float(np.clip(1.0 - worst / limit_deg, 0.0, None).sum() / len(worst))


def _folded_angle_deg(estimate: Affine2D, truth: Affine2D) -> float:
    a, b = estimate.translation, truth.translation
    across = abs(a[0] * b[1] - a[1] * b[0])
    return float(np.degrees(np.arctan2(across, abs(float(a @ b)))))
