# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Detection of odometry drift in a run, by doubled walls and by walls that turn.

A robot that revisits a place observes the same walls twice. Without a revisit, only heading drift
can be detected: buildings keep their wall directions, so these must not turn with the path.
Position drift alone is then undetectable.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
import math

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Placements, rotation
from fpnet_core.localizer.kept import is_brief
from fpnet_core.localizer.pose_filter import FEWEST_POINTS
from fpnet_core.pose import (
    FINE,
    RIGID_STRAIN,
    ROUGH,
    AlignmentPrior,
    MapEvidence,
    map_evidence,
    refine,
    wall_support,
)
from fpnet_core.raster.rays import values_at
from fpnet_core.scoring.findings import DoubleWalls, TurningWalls
from fpnet_core.trajectory import lengths_along
from fpnet_core.types import FREE, OCCUPIED, GridMap, LocalizerOutput, Submap

Array = NDArray[np.float64]

_AWAY_M = 10.0  # physical: path after which a robot at the same place has come back
_BACK_WITHIN_M = 2.5  # physical: distance that counts as back; covers drift of metres
_KNOWN_WITHIN_M = 1.5  # physical: returns farther from all earlier walls are new observations
_KNOWN_SHARE = 0.6  # chosen: share of known returns that identifies a revisited place
_PLACES = 12  # numerical: places compared, spread over the run
_FIT = 0.7  # chosen: share of the walls on earlier ones after alignment
_GAIN = 0.12  # chosen: gain of that share by alignment from which walls count as doubled
_FEWEST_DOUBLED = 2  # chosen: places required; a single one may be a door that was closed
_CELL_M = 0.1  # numerical: of the raster used for the wall direction
_FEWEST_PLACES = 5  # chosen: places along the path that separate a steady turn from a step
_LEAST_STRENGTH = 0.4  # chosen: orientation strength required
_LEAST_TURN_RAD = math.radians(8.0)  # physical: wings of a building differ by more
_STEADY = 0.15  # chosen: deviation of the directions from a steady turn, relative to the turn
# Chosen, not measured:
_RIGID = AlignmentPrior(RIGID_STRAIN, stretch=np.eye(2))
_SHIFTS_M = (-1.0, 0.0, 1.0)  # starts of the alignment
_TURNS_RAD = tuple(math.radians(turn) for turn in (-12.0, -6.0, 0.0, 6.0, 12.0))


def drift_of(outputs: Sequence[LocalizerOutput]) -> DoubleWalls | TurningWalls | None:
    """Return the drift visible in a run's walls; None without any."""
    whole = (output.submap for output in outputs if not is_brief(output))
    submaps = _last_piece([submap for submap in whole if submap is not None])
    return _double_walls(submaps) or _turning_walls(submaps)


def _double_walls(submaps: Sequence[Submap]) -> DoubleWalls | None:
    """Return the displacement of walls observed twice; None if they agree or none were."""
    pairs = list(_revisits(submaps))
    if not pairs:
        return None
    chosen = np.unique(np.linspace(0, len(pairs) - 1, _PLACES).astype(np.int64))
    found = [_displacement(*pairs[index]) for index in chosen]
    double = [drift for drift in found if drift is not None]
    if len(double) < _FEWEST_DOUBLED:
        return None
    return max(double, key=lambda drift: drift.after - drift.before)


def _turning_walls(submaps: Sequence[Submap]) -> TurningWalls | None:
    """Return by how much the wall direction turns; None if it is constant or changes in steps."""
    seen = [(lengths_along(s.path_xy)[-1], _direction(s)) for s in submaps if len(s.path_xy)]
    known = np.array([(path, way) for path, way in seen if way is not None]).reshape(-1, 2)
    path, way = known[:, 0], np.unwrap(known[:, 1], period=math.pi / 2)
    if len(np.unique(path)) < _FEWEST_PLACES:
        return None
    slope, offset = np.polyfit(path, way, 1)
    turn, beside = abs(slope) * np.ptp(path), np.std(way - slope * path - offset)
    if turn < _LEAST_TURN_RAD or beside > _STEADY * turn:
        return None
    return TurningWalls(math.degrees(turn), float(np.ptp(path)))


def _direction(submap: Submap) -> float | None:
    """Return the direction of the newest walls modulo 90 degrees [rad]; None if there is none."""
    if len(submap.recent_xy) < FEWEST_POINTS:
        return None
    low = submap.recent_xy.min(axis=0) - _CELL_M
    rc = np.floor((submap.recent_xy - low) / _CELL_M).astype(np.int64)[:, ::-1]
    cells = np.full(rc.max(axis=0) + 2, FREE, dtype=np.int8)
    cells[rc[:, 0], rc[:, 1]] = OCCUPIED
    seen = map_evidence(GridMap(cells, _CELL_M, submap.T_odom_submap))
    return seen.orientation if seen.orientation_strength >= _LEAST_STRENGTH else None


def _last_piece(submaps: list[Submap]) -> list[Submap]:
    """Return the submaps since the last restart of the localizer."""
    first = len(submaps) - 1
    while first > 0 and submaps[first - 1].id < submaps[first].id:
        first -= 1
    return submaps[max(first, 0) :]


def _revisits(submaps: Sequence[Submap]) -> Iterator[tuple[Submap, Submap, float]]:
    """Yield the submaps before and after a revisit, and the path between them [m]."""
    paths = [lengths_along(submap.path_xy) for submap in submaps]
    for index, later in enumerate(submaps):
        if not len(later.path_xy):
            continue
        path = paths[index]
        near = np.linalg.norm(later.path_xy - later.path_xy[-1], axis=1) < _BACK_WITHIN_M
        been = np.flatnonzero(near & (path < path[-1] - _AWAY_M))
        if not len(been):
            continue
        # The newest map from before the revisit covers the place best.
        before = [k for k in range(index) if _is_between(paths[k][-1:], path, been)]
        if before:
            yield submaps[before[-1]], later, float(path[-1] - paths[before[-1]][-1])


def _is_between(end: Array, path: Array, been: NDArray[np.int64]) -> bool:
    return bool(len(end) and path[been[-1]] + _BACK_WITHIN_M <= end[0] <= path[-1] - _AWAY_M)


def _displacement(first: Submap, later: Submap, path_m: float) -> DoubleWalls | None:
    walls = map_evidence(first.grid)
    T_first_later = first.T_odom_submap.inv() @ later.T_odom_submap
    seen = T_first_later.apply(later.recent_xy)
    seen = seen[_distance(walls, seen) <= _KNOWN_WITHIN_M]
    if len(seen) < max(FEWEST_POINTS, _KNOWN_SHARE * len(later.recent_xy)):
        return None
    at = T_first_later.apply(later.path_xy[-1:])[0]
    moved = refine(walls, seen, _starts(at), _RIGID, ROUGH)
    moved = refine(walls, seen, moved, _RIGID, FINE)
    support = wall_support(walls, seen, moved)
    before = float(wall_support(walls, seen, _identity())[0])
    best = int(support.argmax())
    after = float(support[best])
    if after < _FIT or after - before < _GAIN:
        return None
    shift = moved.linear[best] @ at + moved.translation[best] - at
    turn_deg = abs(math.degrees(math.remainder(float(moved.heading[best]), math.tau)))
    return DoubleWalls(float(np.hypot(*shift)), turn_deg, path_m, before, after)


def _identity() -> Placements:
    return Placements(np.eye(2)[None], np.zeros((1, 2)))


def _starts(at: Array) -> Placements:
    """Return small motions about the robot at ``at (2,)``."""
    turns = rotation(_TURNS_RAD)
    shifts = np.array([(x, y) for x in _SHIFTS_M for y in _SHIFTS_M])
    linear = np.repeat(turns, len(shifts), axis=0)
    return Placements(linear, at - linear @ at + np.tile(shifts, (len(turns), 1)))


def _distance(walls: MapEvidence, points: Array) -> Array:
    """Return the distances of points ``(P, 2)`` to the nearest wall [m]; infinite off the map."""
    rc = points @ walls.A_rc_xy[:, :2].T + walls.A_rc_xy[:, 2]
    return values_at(walls.wall_distance, rc, np.inf).astype(np.float64)
