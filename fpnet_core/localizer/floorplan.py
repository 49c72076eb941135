# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The floorplan as the localizer holds it: in working metres, with its scale and its mirror image.

Working metres are the drawing's nominal ones, unless its scale is unknown: then rooms and doors
suggest how long a true metre is, and everything inside the localizer is in metres so estimated.
What comes out is in nominal metres again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig, ScalePolicy
from fpnet_core.geometry import SE2, Affine2D, Placements
from fpnet_core.localizer.prepared_maps import prepare_plan, prepared_plan
from fpnet_core.localizer.scale import ScaleHistory
from fpnet_core.localizer.tracking import LocalizationState
from fpnet_core.pose import PreparedMap
from fpnet_core.pose_covariance import PoseCovariance
from fpnet_core.segmentation import (
    STATED_SCALE,
    ScaleEstimate,
    segment_unknown_scale,
    told_scale,
)
from fpnet_core.segmentation.moved import mirrored_rooms, rescaled, rescaled_rooms
from fpnet_core.types import GridMap, PlanScale, Segmentation, Status


@dataclass(frozen=True, eq=False)
class Floorplan:
    """
    One floorplan and what has been learned about it.

    ``given`` is the drawing as it came, ``nominal`` is for drawing, ``working`` for comparing; the
    rooms and doors of the last two are the same ones, in the same order. Where the scale is stated
    both are one. ``factor`` is working metres per nominal metre, ``mirror`` the working side of
    the drawing's mirror image, None until somebody has looked at it. ``denial`` is what rooms,
    doors and walls say where that is beyond doubt another scale than was stated. On a site,
    ``name`` is that of the storey, and ``log_prior`` how probable that is before looking, as a
    logarithm.
    """

    given: GridMap
    nominal: PreparedMap
    working: PreparedMap
    factor: float
    scale: ScaleHistory
    mirror: PreparedMap | None = None
    scale_conflict: ScaleEstimate | None = None
    name: str = ''
    log_prior: float = 0.0

    @classmethod
    def prepared(
        cls,
        grid: GridMap,
        config: FpnetConfig,
        estimate: ScaleEstimate | None = None,
        policy: ScalePolicy | None = None,
        segmentation: Segmentation | None = None,
    ) -> Floorplan:
        """
        Return a drawing cut into rooms.

        ``estimate`` is what is known of the scale where it is unknown; None asks rooms and doors.
        ``policy`` is how far this floorplan's is trusted; None: as configured.
        ``segmentation`` are its rooms and doors at the scale it has; None: nobody has cut it.

        Raises
        ------
        MapFormatError
            If the drawing holds no room.
        """
        policy = policy or config.localizer.scale_policy
        if policy != 'unknown':
            estimate = STATED_SCALE
        if estimate is None:
            estimate = segment_unknown_scale(grid, config.segmentation)[1]
        factor = estimate.factor
        if factor == 1.0:
            nominal = working = prepare_plan(grid, config, segmentation)
        else:
            working = prepare_plan(rescaled(grid, factor), config)
            rooms = rescaled_rooms(working.segmentation, 1.0 / factor)
            given = replace(grid, cells=rooms.grid.cells)  # its pose not off by a rounding
            nominal = prepared_plan(replace(rooms, grid=given))
        scale = ScaleHistory.begun(policy, config.pose, estimate)
        scale_conflict = None if policy == 'unknown' else denied_scale(working, config)
        return cls(grid, nominal, working, factor, scale, scale_conflict=scale_conflict)

    @property
    def half_area_m2(self) -> float:
        """Half of the free area: who has seen so much need not see more to be sure."""
        return 0.5 * self.working.evidence.free_area_m2

    def with_mirror(self) -> Floorplan:
        """Return the floorplan with its ``mirror``."""
        if self.mirror is not None:
            return self
        return replace(self, mirror=prepared_plan(mirrored_rooms(self.working.segmentation)))

    def after(self, estimate: LocalizationState, walls: NDArray[np.float64]) -> Floorplan:
        """
        Return the floorplan with what a tick tells of its scale: claims measure it.

        ``walls (P, 2)`` are those of the submap. Being ambiguous again says nothing.
        """
        if estimate.status is Status.LOCALIZED and estimate.best is not None:
            A_plan_submap = estimate.best.A_plan_submap
            return replace(
                self, scale=self.scale.followed(A_plan_submap, walls, estimate.deformation_m)
            )
        is_open = estimate.status is Status.AMBIGUOUS
        return self if is_open else replace(self, scale=self.scale.forgotten())

    def to_working(self, T_plan_base: SE2) -> SE2:
        """Return a pose in nominal metres as one in working metres."""
        return SE2(T_plan_base.linear, T_plan_base.translation * self.factor)

    def placed_in_working(self, A_plan_body: Affine2D) -> Affine2D:
        """Return a placement in nominal metres as one in working metres."""
        return Affine2D(A_plan_body.linear * self.factor, A_plan_body.translation * self.factor)

    def to_nominal(self, A_plan_body: Affine2D) -> Affine2D:
        """Return a placement in working metres as one in nominal metres."""
        return Affine2D(A_plan_body.linear / self.factor, A_plan_body.translation / self.factor)

    def nominal_estimates(self, estimates: Placements) -> Placements:
        """Return placements in working metres as such in nominal metres."""
        A_nominal_working = Affine2D(np.eye(2) / self.factor, np.zeros(2))
        nominal: Placements = A_nominal_working @ estimates
        return nominal

    def nominal_covariance(self, covariance: PoseCovariance) -> PoseCovariance:
        """Return how far a pose in working metres may be off in nominal ones."""
        smaller = np.diag([1.0 / self.factor, 1.0 / self.factor, 1.0])
        growth = covariance.growth
        return replace(
            covariance,
            cov=smaller @ covariance.cov @ smaller,
            growth=replace(
                growth,
                position_per_s=growth.position_per_s / self.factor,
                yaw_per_m=growth.yaw_per_m * self.factor,
            ),
        )

    def nominal_scale(self) -> PlanScale | None:
        """Return what is known of the scale, nominal metres per true metre."""
        found = self.scale.estimate
        return found and replace(found, stretch=found.stretch / self.factor)


def denied_scale(plan: PreparedMap, config: FpnetConfig) -> ScaleEstimate | None:
    """Return what a plan's rooms, doors and walls say of its scale where they deny it, or None."""
    rooms = plan.segmentation
    told = told_scale(rooms.grid, rooms, config.segmentation)
    return told if told.is_scale_conflict else None
