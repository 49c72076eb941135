# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Where a robot should look next: the place whose view tells the most placements apart.

Every placement predicts what would be seen from a place: its drawn walls, as far as they have not
been looked at. Where predictions differ, a look tells which of them is right, and "none of these"
as well, whose walls nobody can predict. A place is worth the information that its view is expected
to bring, in nats, by the way to it: through floor that was seen, and beyond it through what the
best placement has drawn there. It is next-best-view exploration (Connolly, 1985), with
hypotheses of the place in lieu of a map's unknown cells.
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
_MOST_PLACES = 200  # numerical: the nearest ones, some 450 m2
_VIEW_M, _RAYS = 8.0, 48  # numerical: how far and into how many directions a view is predicted
_BEEN_M = 1.0  # physical: from places nearer to the path the same is seen
_SAME_M = 0.4  # physical: ranges that differ by less do not part placements: drawings are so rough
_SETUP_M = 10.0
"""
A place is worth its gain by the way to it and this; fitted by ``python benchmarks/guidance.py
--seed 3000`` among 3, 6 and 10: a robot must not dwell on slivers at hand.
"""

# Chosen, not measured:
_NATS_PER_M = 1.0  # what a metre of wall tells that one placement draws and another does not
_MOST_NATS = 6.0  # no view tells more
_FOREIGN_SHARE = 0.1  # of that: the best places in other buildings explain most walls by chance
_LEAST_NATS = 0.002  # less is not worth a way
_RIVAL_SHARE = 0.01  # of the best placement's probability, from which on another is a rival
_DOUBT = 0.01  # of a place without rivals: a claim takes one look more, wherever from
_HALF = 0.5  # of the best one's probability: less is told from it, as much is its equal
_TINY = 1e-12  # numerical: no logarithm of nothing

_SECTORS = (
    'ahead', 'ahead on the left', 'on the left', 'behind on the left', 'behind',
    'behind on the right', 'on the right', 'ahead on the right',
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class NextLook:
    """
    Where a robot that is not localized should look next.

    ``way_odom (P, 2)`` leads there from the robot, over ``way_m``; the view from its end is
    expected to tell ``gain_nats`` of where the robot is. ``words`` say so.
    """

    way_odom: Array
    way_m: float
    gain_nats: float
    words: str

    def as_json(self) -> dict[str, Any]:
        """Return what JSON says of it."""
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
    Return the place to look from next; None where a claim stands, or no look would tell anything.

    Parameters
    ----------
    plan : evidence of the floorplan that ``output`` is on, nominal metres
    output : of the last tick; one that says that the plan is mirrored has no next look
    T_odom_base : (4, 4), where the robot is
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
    """Tell which places (K, 2) the robot has not been at: what it missed there stays hidden."""
    if not len(xy) or not len(submap.path_xy):
        return np.ones(len(xy), np.bool_)
    return np.asarray(cKDTree(submap.path_xy).query(xy)[0] > _BEEN_M)


@dataclass(frozen=True, eq=False)
class _Views:
    """
    What views from ``K`` places are expected to tell.

    ``gain (K,)`` [nats] is of everything, "none of these" included, ``among (K,)`` of the
    placements alone; ``parted (K,)`` counts those that they tell from the best one.
    """

    gain: Array
    among: Array
    parted: NDArray[np.int64]


def _worth(placed: Placements, views: _Views) -> Array:
    """
    Return what views are worth (K,): all that they tell, none where that is too little.

    Of places that are as probable and that no view parts nothing can be said.
    """
    p, most = placed.probability, views.among.max(initial=0.0)
    is_even = _rivals(placed) and p[1] >= _HALF * p[0] and most < _LEAST_NATS
    return np.where((views.gain >= _LEAST_NATS) & (not is_even), views.gain, 0.0)


def _views(plan: MapEvidence, submap: Submap, placed: Placements, xy: Array) -> _Views:
    """Return what views from ``xy (K, 2)``, submap, are expected to tell."""
    p = placed.probability
    is_rival = p >= _RIVAL_SHARE * p[0]
    other = max(1.0 - float(p.sum()), 0.0 if _rivals(placed) else _DOUBT)
    p, other = p / (p.sum() + other), other / (p.sum() + other)
    ranges, is_new = _predicted(plan, submap, placed, xy)  # (C, K, R), both
    arc = 2.0 * math.pi / _RAYS
    gain, among, parted = np.zeros(len(xy)), np.zeros(len(xy)), np.zeros(len(xy), np.int64)
    for i in range(len(p)):
        # Of two ranges the nearer wall is seen, or not, where it was not looked at.
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
    """Return by how much metres of wall that differ make a placement less probable."""
    return np.asarray(np.exp(-np.minimum(_NATS_PER_M * parted_m, _MOST_NATS)))


def _predicted(
    plan: MapEvidence, submap: Submap, placed: Placements, xy: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the range of each ray under each placement [m], and whether its end is unseen."""
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
    # A wall that is drawn a little behind where it was seen was looked at, too.
    known = grown(grid.cells != UNKNOWN, round(_SAME_M / grid.resolution))
    return ranges, ~values_at(known, grid.xy_to_rc(ends), False)


def _where(way_m: float, corner: Array) -> str:
    """Say where to go: straight to a corner (2,) as seen from the robot, and on."""
    sector = round(math.atan2(corner[1], corner[0]) / (math.tau / len(_SECTORS))) % len(_SECTORS)
    first_m, whole_m = max(1, round(math.hypot(*corner))), max(1, round(way_m))
    first = f'drive {first_m} m {_SECTORS[sector]}'
    return f'{first} and on, {whole_m} m in all' if whole_m > first_m + 1 else first


def _why(parted: int) -> str:
    """Say what for: to tell placements apart, or to see more of the one that there is."""
    if not parted:
        return 'more of what the plan shows can be seen there'
    return f'walls there tell {1 + parted} places apart'


def _rivals(placed: Placements) -> int:
    """Count the placements that a claim of the best one has to rule out."""
    p = placed.probability
    return int(np.count_nonzero(p >= _RIVAL_SHARE * p[0])) - 1
