# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Next best view: the place whose view separates the placements best.

Each placement predicts the view from a place: its plan walls that were not observed yet. A view
whose predictions differ tells which placement is correct, and also whether none is, because
the walls of another building cannot be predicted. A place is scored by the expected information of
its view, in nats, over the path to it: across observed floor, and beyond it across free space of
the best placement. This is next-best-view exploration (Connolly, 1985), with
hypotheses of the pose instead of a map's unknown cells.
"""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fpnet_core.geometry import SE2, Placements
from fpnet_core.localizer.ways import way_grid_around
from fpnet_core.pose import MapEvidence
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.rays import run_lengths, values_at
from fpnet_core.types import UNKNOWN, LocalizerOutput, Status, Submap

Array = NDArray[np.float64]

_MOST_PLACEMENTS = 6  # numerical: placements that are compared
_MOST_PLACES = 200  # numerical: the nearest candidates, about 450 m2
_VIEW_M, _RAYS = 8.0, 48  # numerical: range and number of rays of a predicted view
_BEEN_M = 1.0  # physical: closer to the path, the view is the same
_SAME_M = 0.4  # physical: tolerance of ranges, given the accuracy of drawings
_SETUP_M = 10.0
"""
Path length added to each path before the gain is divided by it; fitted by ``python
benchmarks/guidance.py --seed 3000`` among 3, 6 and 10. It avoids small gains close by.
"""

# Chosen, not measured:
_NATS_PER_M = 1.0  # information of a metre of wall that only one of two placements predicts
_MOST_NATS = 6.0  # upper limit for a view
_FOREIGN_SHARE = 0.1  # of that: the best places in other buildings explain most walls by chance
_LEAST_NATS = 0.002  # smaller gains are not worth a path
_COMPETING_SHARE = 0.01  # probability relative to the best placement from which one competes
_NONE_PROBABILITY = 0.01  # of "none" without competitors: acceptance needs one more update
_HALF = 0.5  # relative probability: below it a placement is separated, above it equally probable
_TINY = 1e-12  # numerical: avoids the logarithm of zero

_SECTORS = (
    'ahead', 'ahead on the left', 'on the left', 'behind on the left', 'behind',
    'behind on the right', 'on the right', 'ahead on the right',
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class NextLook:
    """
    Next place from which a robot that is not localized should observe.

    ``way_odom (P, 2)`` is the path from the robot, ``way_m`` its length; the view from its end is
    expected to give ``gain_nats`` of information about the pose. ``words`` are for the user.
    """

    way_odom: Array
    way_m: float
    gain_nats: float
    words: str

    def as_json(self) -> dict[str, Any]:
        """Return the JSON form."""
        return {
            'words': self.words,
            'way_m': round(self.way_m, 2),
            'gain_nats': round(self.gain_nats, 3),
            'way_odom': np.round(self.way_odom, 2).tolist(),
        }


def next_look(
    plan: MapEvidence, output: LocalizerOutput, T_odom_base: NDArray[np.float64]
) -> NextLook | None:
    """
    Return the next place to observe from; None while localized, or if no view would help.

    Parameters
    ----------
    plan : evidence of the floorplan that ``output`` refers to, nominal metres
    output : of the last update; if the plan is mirrored there is no next place
    T_odom_base : (4, 4), pose of the robot
    """
    submap, placed = output.submap, output.estimates.take(slice(_MOST_PLACEMENTS))
    is_answered = output.status is Status.LOCALIZED or output.is_mirrored
    if is_answered or submap is None or not placed.probability.any():
        return None
    base = submap.T_odom_submap.inv() @ SE2.from_matrix4(T_odom_base)
    ground = way_grid_around(submap, base.translation, (plan, placed[0].A_plan_submap))
    ways = ground.ways(base.translation)
    index = ground.lattice(ways)
    index = index[_is_new(ground.xy(index), submap)]
    index = index[np.argsort(ways.length_m[index], kind='stable')[:_MOST_PLACES]]
    views = _views(plan, submap, placed, ground.xy(index))
    worth = _worth(placed, views) / (ways.length_m[index] + _SETUP_M)
    if not worth.any():
        return None
    best = int(np.argmax(worth))
    way_m, way = float(ways.length_m[index[best]]), ground.xy(ways.to(int(index[best])))
    corner = base.inv().apply(ground.straight(way))
    return NextLook(
        way_odom=submap.T_odom_submap.apply(way),
        way_m=way_m,
        gain_nats=float(views.gain[best]),
        words=f'{_where(way_m, corner)}: {_why(int(views.parted[best]))}',
    )


def _is_new(xy: Array, submap: Submap) -> NDArray[np.bool_]:
    """Return which places (K, 2) are away from the path, from which all has been seen."""
    if not len(xy) or not len(submap.path_xy):
        return np.ones(len(xy), np.bool_)
    return np.asarray(cKDTree(submap.path_xy).query(xy)[0] > _BEEN_M)


@dataclass(frozen=True, eq=False)
class _Views:
    """
    Expected information of views from ``K`` places.

    ``gain (K,)`` [nats] includes "none of these", ``among (K,)`` covers the
    placements only; ``parted (K,)`` counts the placements separated from the best one.
    """

    gain: Array
    among: Array
    parted: NDArray[np.int64]


def _worth(placed: Placements, views: _Views) -> Array:
    """
    Return the gain of views (K,), zero if it is too small.

    It is also zero if two placements are equally probable and no view separates any.
    """
    p, most = placed.probability, views.among.max(initial=0.0)
    is_even = _competitors(placed) and p[1] >= _HALF * p[0] and most < _LEAST_NATS
    return np.where((views.gain >= _LEAST_NATS) & (not is_even), views.gain, 0.0)


def _views(plan: MapEvidence, submap: Submap, placed: Placements, xy: Array) -> _Views:
    """Return the expected information of views from ``xy (K, 2)``, submap frame."""
    p = placed.probability
    is_rival = p >= _COMPETING_SHARE * p[0]
    other = max(1.0 - float(p.sum()), 0.0 if _competitors(placed) else _NONE_PROBABILITY)
    p, other = p / (p.sum() + other), other / (p.sum() + other)
    ranges, is_new = _predicted(plan, submap, placed, xy)  # (C, K, R), both
    arc = 2.0 * math.pi / _RAYS
    gain, among, parted = np.zeros(len(xy)), np.zeros(len(xy)), np.zeros(len(xy), np.int64)
    for i in range(len(p)):
        # Of two ranges the nearer wall decides, if its place was not observed yet.
        is_told = np.where(ranges[i] <= ranges, is_new[i], is_new)
        differs = is_told & (np.abs(ranges[i] - ranges) > _SAME_M)
        left = _left_after((np.minimum(ranges[i], ranges) * differs).sum(axis=2) * arc)
        if i == 0:
            parted = np.count_nonzero((left < _HALF) & is_rival[:, None], axis=0)
        walls_m = (ranges[i] * (is_new[i] & (ranges[i] < _VIEW_M))).sum(axis=1) * arc
        alike = p @ left
        foreign = other * _left_after(_FOREIGN_SHARE * walls_m)
        gain -= p[i] * np.log(np.maximum(alike + foreign, _TINY))
        among -= p[i] / p.sum() * np.log(np.maximum(alike / p.sum(), _TINY))
    return _Views(gain, among, parted)


def _left_after(parted_m: Array) -> Array:
    """Return the factor by which metres of differing wall lower a placement's probability."""
    return np.asarray(np.exp(-np.minimum(_NATS_PER_M * parted_m, _MOST_NATS)))


def _predicted(
    plan: MapEvidence, submap: Submap, placed: Placements, xy: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Return each ray's range per placement [m], and whether its end is unobserved."""
    yaw = np.arange(_RAYS) * (2.0 * math.pi / _RAYS)
    ray = np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
    linear = plan.A_rc_xy[:, :2] @ placed.linear
    starts = placed.apply(xy) @ plan.A_rc_xy[:, :2].T + plan.A_rc_xy[:, 2]
    steps = np.einsum('cij,rj->cri', linear, ray)
    per_m = np.linalg.norm(steps, axis=2, keepdims=True)  # cells a metre
    runs = run_lengths(
        plan.wall_distance > 0.5 * plan.cell_m,
        True,
        starts[:, :, None],
        (steps / per_m)[:, None],
        _VIEW_M * per_m[:, None, :, 0],
        max(1.0, float(placed.scale.max())),
    )
    ranges = np.minimum(runs / per_m[:, None, :, 0], _VIEW_M)
    ends = xy[None, :, None] + ranges[..., None] * ray
    grid = submap.grid
    # Tolerance: a wall drawn slightly behind its observation counts as observed.
    known = grown(grid.cells != UNKNOWN, round(_SAME_M / grid.resolution))
    return ranges, ~values_at(known, grid.xy_to_rc(ends), False)


def _where(way_m: float, corner: Array) -> str:
    """Return directions: straight to a corner (2,) in the robot's frame, then on."""
    sector = round(math.atan2(corner[1], corner[0]) / (math.tau / len(_SECTORS))) % len(_SECTORS)
    first_m, whole_m = max(1, round(math.hypot(*corner))), max(1, round(way_m))
    first = f'drive {first_m} m {_SECTORS[sector]}'
    return f'{first}, then on, {whole_m} m in total' if whole_m > first_m + 1 else first


def _why(parted: int) -> str:
    """Return the purpose: to separate hypotheses, or to observe more of the only one."""
    if not parted:
        return 'unobserved parts of the plan are visible there'
    return f'walls there separate {1 + parted} hypotheses'


def _competitors(placed: Placements) -> int:
    """Count the competitors that must be ruled out to accept the best placement."""
    p = placed.probability
    return int(np.count_nonzero(p >= _COMPETING_SHARE * p[0])) - 1
