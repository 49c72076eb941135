# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Map between a robot map and a drawing that is locally deformed to fit it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import map_coordinates

from fpnet_core.frozen import freeze_field
from fpnet_core.geometry import Affine2D

Array = NDArray[np.float64]

_STEPS = 4  # numerical: fixed-point steps of the inverse; the shifts are smooth over metres


@dataclass(frozen=True, eq=False)
class DeformedPlan:
    """
    Positions of a robot map on a drawing, by one transform and a local shift.

    Parameters
    ----------
    A_plan_map : from the robot map's metres to the drawing's
    shifts : (H, W, 2)
        Added to the transform's result where the drawing is locally displaced [m of the drawing];
        see :func:`fpnet_core.differences.bending.bending`.
    A_rc_map : (2, 3)
        From the robot map's metres to (row, column) of ``shifts``.
    """

    A_plan_map: Affine2D
    shifts: Array
    A_rc_map: Array

    def __post_init__(self) -> None:
        """Check and freeze the arrays."""
        freeze_field(self, 'shifts', np.float64, (None, None, 2))
        freeze_field(self, 'A_rc_map', np.float64, (2, 3))

    def shift_at(self, xy_map: ArrayLike) -> Array:
        """Return the shifts ``(..., 2)`` at positions in the robot map ``(..., 2)`` [m]."""
        rc = np.asarray(xy_map) @ self.A_rc_map[:, :2].T + self.A_rc_map[:, 2]
        at = np.moveaxis(rc, -1, 0)
        each = [
            map_coordinates(self.shifts[..., axis], at, order=1, mode='nearest')
            for axis in range(2)
        ]
        return np.stack(each, axis=-1)

    def drawn_at(self, xy_map: ArrayLike) -> Array:
        """Return where places ``(..., 2)`` of the robot map are drawn, with the local shift."""
        return np.asarray(self.A_plan_map.apply(xy_map) + self.shift_at(xy_map))

    def observed_at(self, xy_plan: ArrayLike) -> Array:
        """Return where drawn places ``(..., 2)`` are in the robot map: inverse of drawn_at."""
        back, drawn = self.A_plan_map.inv(), np.asarray(xy_plan, dtype=np.float64)
        xy_map = back.apply(drawn)
        for _ in range(_STEPS):
            xy_map = back.apply(drawn - self.shift_at(xy_map))
        return xy_map
