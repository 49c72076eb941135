# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Alignment of a matched robot map: transform with its uncertainty, deformation, residuals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet.alignment.deformation import DeformedPlan
from fpnet.alignment.residuals import ObservedWalls, observed_walls
from fpnet.exports.segmented_model import complete_model
from fpnet_core.config import FpnetConfig
from fpnet_core.differences import Differences, find_differences
from fpnet_core.differences.bending import bending
from fpnet_core.drawings.model import FloorplanModel
from fpnet_core.drawings.types import Reading
from fpnet_core.errors import NotPlacedError
from fpnet_core.geometry import Affine2D, Similarity2D
from fpnet_core.localizer import MapMatch, create_global_localizer
from fpnet_core.localizer.global_localizer import MatchQuery
from fpnet_core.localizer.maps import MapMatchStatus
from fpnet_core.localizer.prepared_maps import StageTimer, prepared_plan
from fpnet_core.localizer.tracking import MIRROR_LOG_ODDS
from fpnet_core.pose.uncertainty import Misfit, packaged_uncertainty, wall_information
from fpnet_core.segmentation.moved import mirrored_rooms
from fpnet_core.types import GridMap

Array = NDArray[np.float64]

_DIGITS = 6  # numerical: of transforms


@dataclass(frozen=True, eq=False)
class Alignment:
    """
    A robot map aligned with a drawing.

    Parameters
    ----------
    match : the accepted match
    plan : the drawing; its frame is ``plan``
    robot : the robot map in its own metres; its frame is called ``map``
    deformed : ``T_plan_map`` with the local shifts
    cov : (3, 3)
        Of x, y [m of the drawing] and yaw [rad] at ``centre``.
    centre : (2,)
        Middle of the observed walls on the drawing [m].
    metres : true metres per metre of the drawing
    walls : observed walls with their distances to drawn ones
    model : rooms, walls and doors of the drawing, in its metres
    differences : between drawing and robot map
    """

    match: MapMatch
    plan: Reading
    robot: GridMap
    deformed: DeformedPlan
    cov: Array
    centre: Array
    metres: float
    walls: ObservedWalls
    model: FloorplanModel
    differences: Differences

    @property
    def A_plan_map(self) -> Affine2D:
        """Transform from the robot map's metres to the drawing's."""
        return self.deformed.A_plan_map

    @property
    def S_plan_map(self) -> Similarity2D:
        """Similarity nearest to ``A_plan_map``: equal at the middle of the observed walls."""
        A = self.A_plan_map
        S = Similarity2D.from_scale_yaw(A.scale, A.heading, (0.0, 0.0))
        moved = self.centre - S.apply(A.inv().apply(self.centre))
        return Similarity2D.from_scale_yaw(A.scale, A.heading, moved)

    @cached_property
    def rooms(self) -> list[dict[str, Any]]:
        """Residuals by room; see :meth:`ObservedWalls.by_room`."""
        return self.walls.by_room(self.model)

    def as_json(self) -> dict[str, Any]:
        """Return transform, uncertainty, deformation and residuals as plain values."""
        A, S = self.A_plan_map, self.S_plan_map
        sigma = np.sqrt(np.diag(self.cov))
        shift_m = self.metres * np.hypot(*self.walls.shift.T)
        named = {'storey': self.match.storey} if self.match.storey else {}
        return {
            'status': self.match.status.value,
            'probability': round(self.match.probability, 4),
            'reason': self.match.reason,
            **named,
            'parent_frame': 'plan',
            'child_frame': 'map',
            'T_plan_map': np.round(A.matrix, _DIGITS).tolist(),
            'T_map_plan': np.round(A.inv().matrix, _DIGITS).tolist(),
            'scale': round(A.scale, _DIGITS),
            'yaw_deg': round(math.degrees(A.heading), 4),
            'stretch': np.round(np.linalg.svd(A.linear, compute_uv=False), _DIGITS).tolist(),
            'similarity_plan_map': np.round(S.matrix, _DIGITS).tolist(),
            'similarity_error_m': round(self.similarity_error_m, 3),
            'covariance': {
                'at_xy': np.round(self.centre, 3).tolist(),
                'x_y_yaw': np.round(self.cov, 9).tolist(),
                'sigma_x_m': round(float(sigma[0]), 4),
                'sigma_y_m': round(float(sigma[1]), 4),
                'sigma_yaw_deg': round(math.degrees(sigma[2]), 3),
            },
            'true_metres_per_plan_metre': round(self.metres, _DIGITS),
            'deformation': {
                'rms_m': round(float(np.sqrt((shift_m**2).mean())), 3),
                'p90_m': round(float(np.quantile(shift_m, 0.9)), 3),
                'max_m': round(float(shift_m.max()), 3),
                'grid': self.walls.on_grid(),
            },
            'walls': self.walls.whole,
            'rooms': self.rooms,
        }

    @property
    def similarity_error_m(self) -> float:
        """Largest distance on observed walls between similarity and transform, true metres."""
        placed = self.S_plan_map.apply(self.A_plan_map.inv().apply(self.walls.xy))
        return self.metres * float(np.linalg.norm(placed - self.walls.xy, axis=1).max())


def align_match(match: MapMatch, plan: Reading, robot: GridMap, config: FpnetConfig) -> Alignment:
    """
    Align the robot map of a match with its drawing.

    Parameters
    ----------
    match : of ``robot`` on ``plan``
    plan : the drawing, or that of the match's storey on a site
    robot : the robot map in its own metres
    config : as for the match

    Raises
    ------
    NotPlacedError
        If the match is not accepted, or the drawing's mirror image fits as well.
    """
    if match.status is not MapMatchStatus.MATCHED:
        raise NotPlacedError(f'not placed, so nothing can be aligned: {match.reason}')
    check_mirror(match, config)
    assert match.A_plan_sub is not None  # accepted
    placed = match.candidates.estimates[0].A_plan_submap
    drawn, seen = match.plan, match.sub
    # The match is in metres as stated or estimated, both files are in their own.
    plan_factor = drawn.segmentation.grid.resolution / plan.grid.resolution
    sub_factor = seen.segmentation.grid.resolution / robot.resolution
    A_rc = seen.evidence.A_rc_xy
    deformed = DeformedPlan(
        match.A_plan_sub,
        bending(drawn.evidence, seen.evidence, placed).astype(np.float64) / plan_factor,
        np.column_stack([A_rc[:, :2] * sub_factor, A_rc[:, 2]]),
    )
    walls = seen.evidence.walls
    middle = walls.mean(axis=0)
    unit = np.diag([1.0 / plan_factor, 1.0 / plan_factor, 1.0])
    metres = true_metres(match, plan, plan_factor)
    model = complete_model(plan)
    differences = find_differences(drawn, seen, placed, plan.grid)
    samples = observed_walls(
        walls / sub_factor,
        robot,
        plan.grid,
        drawn.segmentation.labels,
        model,
        differences,
        deformed,
        metres,
        seen.evidence.wall_length_m / len(walls) * placed.scale * metres / plan_factor,
    )
    return Alignment(
        match=match,
        plan=plan,
        robot=robot,
        deformed=deformed,
        cov=unit @ _covariance(match, placed, middle) @ unit,
        centre=placed.apply(middle) / plan_factor,
        metres=metres,
        walls=samples,
        model=model,
        differences=differences,
    )


def true_metres(match: MapMatch, plan: Reading, plan_factor: float) -> float:
    """Return true metres per metre of the drawing: as stated, by the robot map, or estimated."""
    assert match.scale is not None  # there is a placement
    if plan.scale.is_known:
        return 1.0
    return 1.0 / match.scale if match.sub_is_stated else plan_factor


def check_mirror(match: MapMatch, config: FpnetConfig) -> None:
    """
    Search the drawing's mirror image, too, with the prior of a running localizer.

    Raises
    ------
    NotPlacedError
        If it fits so well that the match would not be accepted.
    """
    localizer = create_global_localizer(config)
    mirror = prepared_plan(mirrored_rooms(match.plan.segmentation))
    query = MatchQuery(mirror, match.sub, match.area_m2, match.search)
    mirrored = localizer.find(query, StageTimer()).posterior
    drawn = match.candidates.posterior
    both = localizer.scorer.against_mirror(drawn, mirrored, MIRROR_LOG_ODDS)
    if both.best < config.localizer.match_probability:
        raise NotPlacedError(
            f"the drawing's mirror image fits as well (p {both.mirror:.2f}, the drawing "
            f'{both.best:.2f}): if the drawing is a mirror image, read it with --mirrored; else '
            'map more of the building'
        )


def _covariance(match: MapMatch, placed: Affine2D, middle: Array) -> Array:
    """Return the covariance (3, 3) of the pose at the middle of the walls, the match's metres."""
    evidence = match.candidates.posterior.evidence
    figures = Misfit(
        float(evidence.of('bend_m')[0]), float(evidence.of('residual_75')[0]), 0.0
    ).figures
    walls = match.sub.evidence.walls
    information = wall_information(match.plan.evidence, walls, placed, middle)
    return packaged_uncertainty().covariances(figures, information)
