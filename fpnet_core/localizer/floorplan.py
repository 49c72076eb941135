# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The floorplan as the localizer holds it: in working metres, with its scale and its mirror image.

Working metres are the drawing's nominal ones, unless its scale is unknown: then rooms and doors
suggest how long a true metre is, and everything inside the localizer is in metres so estimated.
What comes out is in nominal metres again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2, Affine2D, Placements
from fpnet_core.judging import Verdict
from fpnet_core.localizer.finder import Finder
from fpnet_core.localizer.scale import ScaleSearch, ScaleTracker
from fpnet_core.localizer.sides import (
    StageTimer,
    plan_side,
    prepare_plan,
    rescaled,
    rescaled_rooms,
)
from fpnet_core.pose import MapSide
from fpnet_core.segmentation import STATED_SCALE, ScaleEstimate, segment_unknown_scale
from fpnet_core.types import GridMap, PlanScale


class Floorplan:
    """
    One floorplan and what has been learned about it.

    ``given`` is the drawing as it came, ``nominal`` is for drawing, ``working`` for comparing; the
    rooms and doors of the last two are the same ones, in the same order. Where the scale is stated
    both are one.

    ``estimate`` is what is known of the scale where it is unknown; None asks rooms and doors.

    Raises
    ------
    MapFormatError
        If the drawing holds no room.
    """

    def __init__(
        self, grid: GridMap, config: FpnetConfig, estimate: ScaleEstimate | None = None
    ) -> None:
        self.given = grid
        self._config = config
        if config.localizer.scale_policy != 'unknown':
            estimate = STATED_SCALE
        if estimate is None:
            estimate = segment_unknown_scale(grid, config.segmentation)[1]
        self._factor = estimate.factor
        self.working = prepare_plan(rescaled(grid, self._factor), config)
        self.nominal = self.working
        if self._factor != 1.0:
            rooms = rescaled_rooms(self.working.segmentation, 1.0 / self._factor)
            nominal = replace(grid, cells=rooms.grid.cells)  # its pose not off by a rounding
            self.nominal = plan_side(replace(rooms, grid=nominal))
        policy = config.localizer.scale_policy
        self.scale = ScaleTracker(policy, config.pose, estimate)
        self._mirrored: MapSide | None = None

    @property
    def half_area_m2(self) -> float:
        """Half of the free area: who has seen so much need not see more to be sure."""
        return 0.5 * self.working.evidence.free_area_m2

    def mirrored(
        self,
        sub: MapSide,
        explored_area_m2: float,
        search: ScaleSearch,
        finder: Finder,
        timer: StageTimer,
    ) -> Verdict:
        """Return the verdict on a submap's placements on the drawing's mirror image."""
        with timer.stage('mirror'):
            if self._mirrored is None:
                grid = self.working.segmentation.grid
                self._mirrored = prepare_plan(grid.mirrored(), self._config)
            # Its stages are not the drawing's.
            found = finder.find(self._mirrored, sub, explored_area_m2, search, StageTimer())
        return found.verdict

    def to_working(self, T_plan_base: SE2) -> SE2:
        """Return a pose in nominal metres as one in working metres."""
        return SE2(T_plan_base.linear, T_plan_base.translation * self._factor)

    def to_nominal(self, A_plan_body: Affine2D) -> Affine2D:
        """Return a placement in working metres as one in nominal metres."""
        return Affine2D(A_plan_body.linear / self._factor, A_plan_body.translation / self._factor)

    def nominal_estimates(self, estimates: Placements) -> Placements:
        """Return placements in working metres as such in nominal metres."""
        A_nominal_working = Affine2D(np.eye(2) / self._factor, np.zeros(2))
        nominal: Placements = A_nominal_working @ estimates
        return nominal

    def nominal_scale(self) -> PlanScale | None:
        """Return what is known of the scale, nominal metres per true metre."""
        found = self.scale.estimate
        return found and replace(found, stretch=found.stretch / self._factor)
