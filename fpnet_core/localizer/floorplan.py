# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The localizer's floorplan in working metres, with its scale and mirror image.

Working metres are the drawing's nominal ones, unless its scale is unknown: then rooms and doors
give an estimate of the true metre, and the localizer works in metres so estimated.
Its results are converted back to nominal metres.
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
    One floorplan and what was estimated about it.

    ``given`` is the drawing as received, ``nominal`` is for drawing, ``working`` for comparing;
    the last two have the same rooms and doors in the same order. If the scale is stated they are
    the same object. ``factor`` is working metres per nominal metre, ``mirror`` the prepared map of
    the drawing's mirror image in working metres, None until it is needed. ``scale_conflict`` is
    the scale by rooms, doors and walls if it contradicts the stated one significantly. On a site,
    ``name`` is that of the storey, and ``log_prior`` its log prior.
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
        Return a drawing segmented into rooms.

        ``estimate`` is the prior if the scale is unknown; None: estimate it by rooms and doors.
        ``policy`` is the scale policy of this floorplan; None: as configured.
        ``segmentation`` are its rooms and doors at its scale; None: compute it.

        Raises
        ------
        MapFormatError
            If the drawing contains no room.
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
            given = replace(grid, cells=rooms.grid.cells)  # keeps the exact pose of the grid
            nominal = prepared_plan(replace(rooms, grid=given))
        scale = ScaleHistory.begun(policy, config.pose, estimate)
        scale_conflict = None if policy == 'unknown' else denied_scale(working, config)
        return cls(grid, nominal, working, factor, scale, scale_conflict=scale_conflict)

    @property
    def half_area_m2(self) -> float:
        """Half of the free area; after observing that much, acceptance needs no new floor."""
        return 0.5 * self.working.evidence.free_area_m2

    def with_mirror(self) -> Floorplan:
        """Return the floorplan with ``mirror`` computed."""
        if self.mirror is not None:
            return self
        return replace(self, mirror=prepared_plan(mirrored_rooms(self.working.segmentation)))

    def after(self, estimate: LocalizationState, walls: NDArray[np.float64]) -> Floorplan:
        """
        Return the floorplan with its scale updated: accepted placements measure it.

        ``walls (P, 2)`` are those of the submap. An ambiguous update changes nothing.
        """
        if estimate.status is Status.LOCALIZED and estimate.best is not None:
            A_plan_submap = estimate.best.A_plan_submap
            return replace(
                self, scale=self.scale.followed(A_plan_submap, walls, estimate.deformation_m)
            )
        is_open = estimate.status is Status.AMBIGUOUS
        return self if is_open else replace(self, scale=self.scale.forgotten())

    def to_working(self, T_plan_base: SE2) -> SE2:
        """Return a pose given in nominal metres in working metres."""
        return SE2(T_plan_base.linear, T_plan_base.translation * self.factor)

    def placed_in_working(self, A_plan_body: Affine2D) -> Affine2D:
        """Return a placement given in nominal metres in working metres."""
        return Affine2D(A_plan_body.linear * self.factor, A_plan_body.translation * self.factor)

    def to_nominal(self, A_plan_body: Affine2D) -> Affine2D:
        """Return a placement given in working metres in nominal metres."""
        return Affine2D(A_plan_body.linear / self.factor, A_plan_body.translation / self.factor)

    def nominal_estimates(self, estimates: Placements) -> Placements:
        """Return placements given in working metres in nominal metres."""
        A_nominal_working = Affine2D(np.eye(2) / self.factor, np.zeros(2))
        nominal: Placements = A_nominal_working @ estimates
        return nominal

    def nominal_covariance(self, covariance: PoseCovariance) -> PoseCovariance:
        """Return a pose covariance given in working metres in nominal metres."""
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
        """Return the estimated scale, nominal metres per true metre; None if unknown."""
        found = self.scale.estimate
        return found and replace(found, stretch=found.stretch / self.factor)


def denied_scale(plan: PreparedMap, config: FpnetConfig) -> ScaleEstimate | None:
    """Return the scale by a plan's rooms, doors and walls if it contradicts the plan's own."""
    rooms = plan.segmentation
    told = told_scale(rooms.grid, rooms, config.segmentation)
    return told if told.is_scale_conflict else None
