# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Walls and floor on a coarse raster, and how well those of two maps fit each other.

Doors and corners of cluttered rooms are found in any large plan by chance. Walls tell: they are
compared by their correlation over what was seen, which is nought where only chance lays walls on
walls, however many of them a plan has.
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

# Chosen: edge of a cell [m], about that of a thick wall; plans take two kilobytes so.
_CELL_M = 0.25
_MOST_POINTS = 1500  # numerical: cells of what was seen that are compared
# Chosen: drawings are stretched by some per cent, and scales are tried in steps of six.
_FREEDOM = AlignmentPrior(0.03)
_MARGIN_M = 2.0  # numerical: further than placements are moved and walls are looked for
LEAST = 0.01
"""Numerical: what fits worse than chance keeps the order of its keypoints."""


def plan_walls(segmentation: Segmentation, factor: float = 1.0) -> GridMap:
    """Return a plan that was cut into rooms as :func:`coarse` does: floor is where rooms are."""
    return coarse(segmentation, interior_of(segmentation), factor)


def seen_walls(segmentation: Segmentation, factor: float = 1.0) -> GridMap:
    """Return what a robot has seen as :func:`coarse` does: floor is all that is free."""
    return coarse(segmentation, segmentation.grid.cells == FREE, factor)


def coarse(segmentation: Segmentation, floor: NDArray[np.bool_], factor: float) -> GridMap:
    """
    Return ``floor (H, W)`` and the walls beside it, ``factor`` times as large, around the middle.

    A cell that holds wall is wall; cells are about a quarter of a metre wide.
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
    """Return the direction that most walls run in, or across [rad], below a right angle."""
    turned, _ = dominant_orientation(walls.cells == OCCUPIED)
    return float((turned + walls.T_frame_grid.yaw) % (np.pi / 2.0))


def area_of(walls: GridMap) -> float:
    """Return how much is known [m^2]."""
    return float(np.count_nonzero(walls.cells != UNKNOWN)) * walls.resolution**2


def packed(walls: GridMap) -> bytes:
    """Return the cells in few bytes: which are wall, and which are known."""
    planes = walls.cells == OCCUPIED, walls.cells != UNKNOWN
    return zlib.compress(b''.join(np.packbits(plane).tobytes() for plane in planes), 9)


def unpacked(data: bytes, shape: tuple[int, int]) -> NDArray[np.int8]:
    """
    Return the cells ``shape`` of :func:`packed`.

    Raises
    ------
    LibraryError
        If they are others.
    """
    size = shape[0] * shape[1]
    try:
        bits = np.frombuffer(zlib.decompress(data), np.uint8).reshape(2, -1)
        planes = np.unpackbits(bits, axis=1, count=size).reshape(2, *shape).view(np.bool_)
    except (zlib.error, ValueError) as error:
        raise LibraryError(
            f'walls of a plan are damaged ({error}); build the library again'
        ) from error
    return np.where(planes[0], OCCUPIED, np.where(planes[1], FREE, UNKNOWN)).astype(np.int8)


@dataclass(frozen=True, eq=False)
class SeenWalls:
    """
    What was seen, to be compared with many plans.

    ``points (P, 2)`` [m] are some of its known cells and ``distance (P,)`` [m] how far from each
    the nearest wall is.
    """

    evidence: MapEvidence
    points: NDArray[np.float64]
    distance: NDArray[np.float32]

    @classmethod
    def of(cls, walls: GridMap) -> SeenWalls:
        """Return the walls and floor of a coarse raster."""
        known = np.argwhere(walls.cells != UNKNOWN)
        known = known[:: max(1, len(known) // _MOST_POINTS)]
        evidence = map_evidence(walls)
        distance = evidence.wall_distance[known[:, 0], known[:, 1]]
        return cls(evidence, walls.rc_to_xy(known), distance)

    def laid(
        self, plan: GridMap, candidates: Placements
    ) -> tuple[NDArray[np.float64], Placements]:
        """
        Return how well each of ``C`` placements fits a plan's coarse raster, ``(C,)``, above 0.

        They are first moved to where walls lie on walls, which is returned, too. The correlation
        of both maps' walls, less the share of seen floor that lies outside the plan, counts for
        more where what was seen covers more of the plan: chance does less there.
        """
        fields = _fields(_around(plan, _at(candidates, self.evidence.corners)))
        aligned = refine(fields, self.evidence.walls, candidates, _FREEDOM, ROUGH)
        violation = agreement(fields, self.evidence, aligned, WALL_SIGMA_M).free_violation
        scale = aligned.scale
        own = np.exp(-0.5 * np.square(scale[:, None] * self.distance / WALL_SIGMA_M))
        placed = _likelihood_at(fields, _at(aligned, self.points))
        found = scale * (_correlation(own, placed) - violation)
        return np.asarray(np.maximum(found, LEAST), dtype=np.float64), aligned


def _at(placements: Placements, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where ``C`` placements put points (P, 2), as (C, P, 2)."""
    placed = np.einsum('cij,pj->cpi', placements.linear, points)
    return np.asarray(placed + placements.translation[:, None])


def _around(plan: GridMap, points: NDArray[np.float64]) -> GridMap:
    """Return the part of a plan around points (C, P, 2), at least a cell: fields take time."""
    rc = plan.xy_to_rc(points.reshape(-1, 2))
    margin = _MARGIN_M / plan.resolution
    last = np.array(plan.shape) - 1
    low = np.clip(np.floor(rc.min(axis=0) - margin).astype(np.int64), 0, last)
    high = np.clip(np.ceil(rc.max(axis=0) + margin).astype(np.int64), low, last)
    rows, cols = (slice(a, b + 1) for a, b in zip(low.tolist(), high.tolist(), strict=True))
    return plan.cropped(rows, cols)


def _fields(plan: GridMap) -> MapEvidence:
    """Return the evidence of a coarse raster as far as it is asked for: without samples."""
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
    """Return the plan's wall likelihood at points (C, P, 2), as (C, P); none outside of it."""
    field = plan.wall_likelihood(WALL_SIGMA_M)
    rc = np.rint(points @ plan.A_rc_xy[:, :2].T + plan.A_rc_xy[:, 2]).astype(np.int64)
    is_inside = ((rc >= 0) & (rc < field.shape)).all(axis=-1)
    rc[~is_inside] = 0
    return np.where(is_inside, field[rc[..., 0], rc[..., 1]], 0.0)


def _correlation(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the correlation (C,) of rows (C, P); 0 where one of them is the same everywhere."""
    a, b = a - a.mean(axis=1, keepdims=True), b - b.mean(axis=1, keepdims=True)
    norm = np.sqrt(np.square(a).sum(axis=1) * np.square(b).sum(axis=1))
    return np.asarray((a * b).sum(axis=1) / np.maximum(norm, 1e-9), dtype=np.float64)
