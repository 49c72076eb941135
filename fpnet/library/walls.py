# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Walls and floor on a coarse raster, and the fit of two such rasters.

In a large plan, doors and corners of cluttered rooms match by chance. The correlation of walls
over the observed area decides: its expectation for chance overlaps is zero, however many walls a
plan has.
"""

from __future__ import annotations

from dataclasses import dataclass
import zlib

import numpy as np
from numpy.typing import NDArray

from fpnet.library.keypoints import middle_of
from fpnet_core.errors import LibraryError
from fpnet_core.geometry import SE2, Placements
from fpnet_core.localizer.prepared_maps import interior_of
from fpnet_core.pose import MapEvidence, agreement, map_evidence
from fpnet_core.pose.evidence import distance_to, dominant_orientation
from fpnet_core.pose.refine import ROUGH, AlignmentPrior, refine
from fpnet_core.pose.verify import WALL_SIGMA_M
from fpnet_core.raster.blocks import block_any
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.pixels import xy_to_rc
from fpnet_core.segmentation.moved import rescaled
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Segmentation

# Chosen: edge of a cell [m], about a thick wall; a plan then takes two kilobytes.
_CELL_M = 0.25
_MOST_POINTS = 1500  # numerical: cells of the robot map that are compared
# Chosen: drawings are stretched by some per cent, and scales are tried in steps of six per cent.
_PRIOR = AlignmentPrior(0.03)
_MARGIN_M = 2.0  # numerical: more than alignment moves placements and searches walls
LEAST = 0.01
"""Numerical: lower bound of the fit of walls; at the bound, the keypoints decide the order."""


def plan_walls(segmentation: Segmentation, factor: float = 1.0) -> GridMap:
    """Return the coarse raster of a segmented plan, see :func:`coarse`; rooms are the floor."""
    return coarse(segmentation, interior_of(segmentation), factor)


def seen_walls(segmentation: Segmentation, factor: float = 1.0) -> GridMap:
    """Return the coarse raster of a robot map, see :func:`coarse`; free space is the floor."""
    return coarse(segmentation, segmentation.grid.cells == FREE, factor)


def coarse(segmentation: Segmentation, floor: NDArray[np.bool_], factor: float) -> GridMap:
    """
    Return ``floor (H, W)`` and the walls beside it as a coarse raster, scaled by ``factor``.

    A cell that contains wall is wall; cells are about 0.25 m wide; the map's middle is the origin.
    """
    grid = segmentation.grid
    step = max(1, round(_CELL_M / (grid.resolution * factor)))
    is_floor = block_any(floor, step)
    is_wall = block_any((grid.cells == OCCUPIED) & ~floor, step) & grown(is_floor, 1)
    cells = np.where(is_wall, OCCUPIED, np.where(is_floor, FREE, UNKNOWN)).astype(np.int8)
    known = cells != UNKNOWN
    if known.any():
        rows, cols = (np.flatnonzero(known.any(axis=axis)) for axis in (1, 0))
        window = slice(rows[0], rows[-1] + 1), slice(cols[0], cols[-1] + 1)
    else:
        window = slice(0, 1), slice(0, 1)
    origin = grid.T_frame_grid
    moved = SE2(origin.linear, origin.translation - middle_of(segmentation))
    blocks = GridMap(cells, grid.resolution * step, moved, grid.frame)
    return rescaled(blocks.cropped(*window), factor)


def direction_of(walls: GridMap) -> float:
    """Return the dominant wall direction [rad], modulo a right angle."""
    turned, _ = dominant_orientation(walls.cells == OCCUPIED)
    return float((turned + walls.T_frame_grid.yaw) % (np.pi / 2.0))


def area_of(walls: GridMap) -> float:
    """Return the known area [m^2]."""
    return float(np.count_nonzero(walls.cells != UNKNOWN)) * walls.resolution**2


def packed(walls: GridMap) -> bytes:
    """Return the compressed cells: a plane of walls and a plane of known cells."""
    planes = walls.cells == OCCUPIED, walls.cells != UNKNOWN
    return zlib.compress(b''.join(np.packbits(plane).tobytes() for plane in planes), 9)


def unpacked(data: bytes, shape: tuple[int, int]) -> NDArray[np.int8]:
    """
    Return the cells of :func:`packed`, with their ``shape``.

    Raises
    ------
    LibraryError
        If the data are damaged.
    """
    size = shape[0] * shape[1]
    try:
        bits = np.frombuffer(zlib.decompress(data), np.uint8).reshape(2, -1)
        planes = np.unpackbits(bits, axis=1, count=size).reshape(2, *shape).view(np.bool_)
    except (zlib.error, ValueError) as error:
        raise LibraryError(
            f'the walls of a plan are damaged ({error}); build the library again'
        ) from error
    return np.where(planes[0], OCCUPIED, np.where(planes[1], FREE, UNKNOWN)).astype(np.int8)


@dataclass(frozen=True, eq=False)
class SeenWalls:
    """
    A robot map, prepared for the comparison with many plans.

    ``points (P, 2)`` [m] are samples of its known cells and ``distance (P,)`` [m] their distances
    to the nearest wall.
    """

    evidence: MapEvidence
    points: NDArray[np.float64]
    distance: NDArray[np.float32]

    @classmethod
    def of(cls, walls: GridMap) -> SeenWalls:
        """Prepare the walls and floor of a coarse raster."""
        known = np.argwhere(walls.cells != UNKNOWN)
        known = known[:: max(1, len(known) // _MOST_POINTS)]
        evidence = map_evidence(walls)
        distance = evidence.wall_distance[known[:, 0], known[:, 1]]
        return cls(evidence, walls.rc_to_xy(known), distance)

    def laid(
        self, plan: GridMap, candidates: Placements
    ) -> tuple[NDArray[np.float64], Placements]:
        """
        Return the fits ``(C,)`` > 0 of ``C`` placements on a plan's coarse raster, aligned.

        Placements are first aligned to the walls and returned as well. The fit is the correlation
        of both maps' walls minus the share of observed floor outside the plan, times the scale: a
        map that covers more of the plan fits less by chance.
        """
        fields = _fields(_around(plan, _at(candidates, self.evidence.corners)))
        aligned = refine(fields, self.evidence.walls, candidates, _PRIOR, ROUGH)
        violation = agreement(fields, self.evidence, aligned, WALL_SIGMA_M).free_violation
        scale = aligned.scale
        own = np.exp(-0.5 * np.square(scale[:, None] * self.distance / WALL_SIGMA_M))
        placed = _likelihood_at(fields, _at(aligned, self.points))
        found = scale * (_correlation(own, placed) - violation)
        return np.asarray(np.maximum(found, LEAST), dtype=np.float64), aligned


def _at(placements: Placements, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points (P, 2) at ``C`` placements, as (C, P, 2)."""
    placed = np.einsum('cij,pj->cpi', placements.linear, points)
    return np.asarray(placed + placements.translation[:, None])


def _around(plan: GridMap, points: NDArray[np.float64]) -> GridMap:
    """Return the part of a plan around points (C, P, 2), at least a cell, to save time."""
    rc = plan.xy_to_rc(points.reshape(-1, 2))
    margin = _MARGIN_M / plan.resolution
    last = np.array(plan.shape) - 1
    low = np.clip(np.floor(rc.min(axis=0) - margin).astype(np.int64), 0, last)
    high = np.clip(np.ceil(rc.max(axis=0) + margin).astype(np.int64), low, last)
    rows, cols = (slice(a, b + 1) for a, b in zip(low.tolist(), high.tolist(), strict=True))
    return plan.cropped(rows, cols)


def _fields(plan: GridMap) -> MapEvidence:
    """Return the evidence of a coarse raster, without the samples, which are not needed."""
    known = plan.cells != UNKNOWN
    nothing = np.zeros((0, 2))
    return MapEvidence(
        walls=nothing,
        free=nothing,
        wall_distance=distance_to(plan.cells == OCCUPIED, plan.resolution, 1),
        observed=known,
        A_rc_xy=xy_to_rc(plan, 1),
        cell_m=plan.resolution,
        orientation=0.0,
        orientation_strength=0.0,
        is_free=known,
        resolution_m=plan.resolution,
    )


def _likelihood_at(plan: MapEvidence, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the plan's wall likelihood at points (C, P, 2), as (C, P); 0 outside the plan."""
    field = plan.wall_likelihood(WALL_SIGMA_M)
    rc = np.rint(points @ plan.A_rc_xy[:, :2].T + plan.A_rc_xy[:, 2]).astype(np.int64)
    is_inside = ((rc >= 0) & (rc < field.shape)).all(axis=-1)
    rc[~is_inside] = 0
    return np.where(is_inside, field[rc[..., 0], rc[..., 1]], 0.0)


def _correlation(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the correlation (C,) of rows (C, P); 0 if one of them is constant."""
    a, b = a - a.mean(axis=1, keepdims=True), b - b.mean(axis=1, keepdims=True)
    norm = np.sqrt(np.square(a).sum(axis=1) * np.square(b).sum(axis=1))
    return np.asarray((a * b).sum(axis=1) / np.maximum(norm, 1e-9), dtype=np.float64)
