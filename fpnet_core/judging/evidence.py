# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What speaks for and against each placement of a submap on a plan, as figures.

Walls at several widths, before and after a small smooth deformation of the drawing; free space
that drawn walls deny; drawn walls that were not seen; rooms and doors as a whole; the matcher's
own opinion; and rivals, which are compared only where they disagree. The figures do not depend on
how either map is turned or where it lies, nor on the order of the placements.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.judging import kernels
from fpnet_core.judging.deform import Deformation, deform, patches_of
from fpnet_core.types import MatchResult, RegionLabel, Segmentation

Array = NDArray[np.float64]

_MAX_WALLS, _MAX_FREE, _MAX_DRAWN = 900, 700, 3000
"""Samples of either side that are looked up; they are spread evenly."""

_WIDTHS_M = (0.1, 0.2, 0.4)
_BEYOND_M = 3.0
_QUANTILES = (0.5, 0.75, 0.9)
_TOLERATED_M, _FULLY_OUTSIDE_M = 0.3, 1.0  # free space may overlap a drawn wall by this much
_ON_WALL_M = 0.1
_SEEN_EDGES_M = np.array([0.15, 0.3, 0.6])
_PATCH_EXPLAINED = 0.35
_DOOR_NEAR_M, _DOOR_FAR_M = 0.5, 1.0
_WELL_SEEN = 0.9
_LEAST_PROBABILITY = 1e-3
_SAME_M = 1.5

FIGURES = (
    'support_fine', 'support', 'support_wide',
    'straight_support', 'straight_aligned',
    'residual_50', 'residual_75', 'residual_90',
    'patches_unexplained', 'unexplained_m',
    'bent_support', 'bent_support_fine', 'bend_m', 'bend_rough_m', 'bend_gain',
    'contrast_mean', 'contrast_least',
    'seen_fine', 'seen', 'denied', 'denied_m', 'bent_seen', 'bent_denied',
    'outside', 'on_wall', 'outside_m2',
    'rooms_pure', 'plan_rooms_pure', 'rooms_alike', 'rooms_complete', 'plan_share',
    'doors_met', 'doors_near', 'doors_missing', 'doors_counted',
    'match_rooms', 'match_doors', 'match_whole',
    'log_scale', 'log_scale_size', 'strain', 'score', 'bent_score',
    'rival_net', 'rival_net_bent', 'rival_z', 'rival_contested', 'rival_score', 'rival_bent_score',
    'rival_doors', 'rival_rooms', 'rival_match', 'rival_denied',
)  # fmt: skip
"""Figures of one placement, in the order of the columns."""

CONTEXT = (
    'log_walls_m', 'log_free_m2', 'log_rooms', 'log_doors', 'log_plan_m2', 'plan_density',
    'log_candidates', 'scale_range', 'straightness', 'best_score', 'second_score', 'mean_score',
)  # fmt: skip
"""Figures of the whole comparison."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """
    Figures of ``C`` placements and of the comparison as a whole.

    ``figures (C, len(FIGURES))`` and ``context (len(CONTEXT),)`` are float32;
    ``deformation`` is how each placement would bend the drawing.
    """

    figures: NDArray[np.float32]
    context: NDArray[np.float32]
    deformation: Deformation | None

    def __len__(self) -> int:
        """Count the placements."""
        return len(self.figures)


def gather_evidence(plan, sub, linear, translation, match, scale_range) -> Evidence:
    """Return the evidence for ``C`` placements."""
    count = len(linear)
    if count == 0 or not len(sub.evidence.walls):
        return Evidence(
            np.zeros((count, len(FIGURES)), np.float32), np.zeros(len(CONTEXT), np.float32), None
        )
    ev, pe = sub.evidence, plan.evidence
    walls, free = _every(ev.walls, _MAX_WALLS), _every(ev.free, _MAX_FREE)
    metres = ev.wall_length_m / len(walls)
    scale = np.sqrt(np.abs(np.linalg.det(linear)))
    to_plan = _chained(pe.A_rc_xy, linear, translation)
    out = {}
    patches = patches_of(walls, ev)
    bent = deform(pe, to_plan, walls, patches)
    # --- forward, walls
    straight, angle = straightness(ev)
    weight, direction = _sampled(ev, walls, straight), _sampled(ev, walls, angle)
    rest = np.zeros_like(bent.shift_cells)
    d, cell = kernels.wall_distances(to_plan, walls, patches.of_wall, rest, pe.wall_distance, _BEYOND_M)
    db, _ = kernels.wall_distances(
        to_plan, walls, patches.of_wall, bent.shift_cells, pe.wall_distance, _BEYOND_M
    )
    likelihood = {w: np.exp(-0.5 * np.square(d / np.float32(w))) for w in _WIDTHS_M}
    for name, w in zip(('support_fine', 'support', 'support_wide'), _WIDTHS_M, strict=True):
        out[name] = likelihood[w].mean(axis=1)
    total = max(float(weight.sum()), 1e-6)
    out['straight_support'] = likelihood[0.2] @ weight / total
    out['straight_aligned'] = _aligned(plan, likelihood[0.2], cell, weight, direction, linear) / total
    for q in _QUANTILES:
        out[f'residual_{round(100 * q)}'] = np.quantile(d, q, axis=1)
    share, sizes = _by_patch(likelihood[0.2], patches)
    unexplained = (share < _PATCH_EXPLAINED) * sizes
    out['patches_unexplained'] = unexplained.sum(axis=1) / sizes.sum()
    out['unexplained_m'] = np.log1p(unexplained.sum(axis=1) * metres)
    lb = np.exp(-0.5 * np.square(db / np.float32(0.2)))
    out['bent_support'] = lb.mean(axis=1)
    out['bent_support_fine'] = np.exp(-0.5 * np.square(db / np.float32(0.1))).mean(axis=1)
    out['bend_m'], out['bend_rough_m'] = bent.size_m, bent.roughness_m
    out['bend_gain'] = out['bent_support'] - out['support']
    out['contrast_mean'], out['contrast_least'] = bent.contrast_mean, bent.contrast_least
    # --- backward, drawn walls
    inverse = np.linalg.inv(linear)
    back = -np.einsum('cij,cj->ci', inverse, translation)
    to_sub = _chained(ev.A_rc_xy, inverse, back)
    drawn = _every(pe.walls, _MAX_DRAWN)
    drawn_m = pe.wall_length_m / max(len(drawn), 1)
    undone = _undone(bent.shift_cells, pe, linear, ev)
    plain, shifted = kernels.drawn_walls(
        to_sub, drawn, ev.wall_distance, ev.observed, patches.of_cell, undone, _SEEN_EDGES_M
    )
    n = np.maximum(plain.sum(axis=1), 1.0)
    out['seen_fine'], out['seen'] = plain[:, 0] / n, plain[:, :2].sum(axis=1) / n
    out['denied'] = plain[:, 3] / n
    out['denied_m'] = np.log1p(plain[:, 3] * drawn_m)
    out['bent_seen'] = shifted[:, :2].sum(axis=1) / n
    out['bent_denied'] = shifted[:, 3] / n
    # --- free space
    depth = kernels.look_up(to_plan, free, pe.outside_depth, _BEYOND_M)
    outside = np.clip((depth - _TOLERATED_M) / (_FULLY_OUTSIDE_M - _TOLERATED_M), 0.0, 1.0)
    out['outside'] = outside.mean(axis=1) if len(free) else np.zeros(count)
    out['outside_m2'] = np.log1p(outside.mean(axis=1) * ev.free_area_m2) if len(free) else np.zeros(count)
    near = kernels.look_up(to_plan, free, pe.wall_distance, _BEYOND_M)
    out['on_wall'] = (near <= _ON_WALL_M).mean(axis=1) if len(free) else np.zeros(count)
    out |= _rooms(plan, sub, to_plan, free, scale)
    out |= _doors(plan, sub, linear, translation, to_sub)
    out |= _matches(plan, sub, linear, translation, to_plan, match)
    # --- placement itself
    out['log_scale'], out['log_scale_size'] = np.log(scale), np.abs(np.log(scale))
    singular = np.linalg.svd(linear, compute_uv=False)
    out['strain'] = np.log(singular[:, 0] / singular[:, 1])
    out['score'] = np.sqrt(out['support'] * out['seen']) - out['outside']
    out['bent_score'] = np.sqrt(out['bent_support'] * out['bent_seen']) - out['outside']
    # --- rivals
    out |= _rivals(out, likelihood[0.2], lb, metres)
    figures = np.stack([out[name] for name in FIGURES], axis=1).astype(np.float32)
    ranked = np.sort(out['bent_score'])[::-1]
    rooms = sum(r.label is RegionLabel.ROOM for r in sub.segmentation.regions)
    context = np.array([
        np.log(ev.wall_length_m + 1.0), np.log(ev.free_area_m2 + 1.0),
        np.log1p(rooms), np.log1p(len(sub.segmentation.portals)),
        np.log(pe.free_area_m2 + 1.0), pe.wall_length_m / max(pe.free_area_m2, 1.0),
        np.log(count), scale_range, float(weight.mean()),
        ranked[0], ranked[1] if count > 1 else 0.0, ranked.mean(),
    ], dtype=np.float32)  # fmt: skip
    return Evidence(figures, context, bent)


def _every(points: Array, limit: int) -> Array:
    """Return at most ``limit`` of the points, evenly drawn."""
    if len(points) <= limit:
        return points
    return points[np.linspace(0, len(points) - 1, limit).astype(np.int64)]


def _chained(A_rc_xy: Array, linear: Array, translation: Array) -> Array:
    A = np.empty((len(linear), 2, 3))
    A[:, :, :2] = A_rc_xy[:, :2] @ linear
    A[:, :, 2] = translation @ A_rc_xy[:, :2].T + A_rc_xy[:, 2]
    return A


def straightness(side) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """How straight walls run around each cell, in [0, 1], and twice their direction [rad]."""
    field = np.exp(-0.5 * np.square(side.wall_distance / np.float32(0.2)))
    gx, gy = cv2.Sobel(field, cv2.CV_32F, 1, 0), cv2.Sobel(field, cv2.CV_32F, 0, 1)
    blur = lambda image: cv2.GaussianBlur(image, (0, 0), 4.0)  # noqa: E731
    xx, yy, xy = blur(gx * gx), blur(gy * gy), blur(gx * gy)
    coherence = np.sqrt((xx - yy) ** 2 + 4.0 * xy**2) / (xx + yy + np.float32(1e-6))
    return coherence, np.arctan2(2.0 * xy, xx - yy)


def _sampled(side, points: Array, raster: NDArray[np.float32]) -> NDArray[np.float32]:
    A = side.A_rc_xy
    rc = np.rint(points @ A[:, :2].T + A[:, 2]).astype(np.int64)
    rc = np.clip(rc, 0, np.array(raster.shape) - 1)
    return raster[rc[:, 0], rc[:, 1]]


def _yaw_in_raster(A_rc_xy: Array) -> float:
    """Direction of the columns' axis in metres."""
    inverse = np.linalg.inv(A_rc_xy[:, :2])
    return float(np.arctan2(inverse[1, 1], inverse[0, 1]))


_plan_fields: dict[int, tuple] = {}


def _plan_straightness(plan):
    key = id(plan.evidence)
    if key not in _plan_fields:
        if len(_plan_fields) > 64:
            _plan_fields.clear()
        _plan_fields[key] = (plan.evidence, *straightness(plan.evidence))
    return _plan_fields[key][1:]


def _aligned(plan, likelihood, cell, weight, direction, linear) -> Array:
    coherence, angle = _plan_straightness(plan)
    known = cell >= 0
    at = np.where(known, cell, 0)
    there = angle.ravel()[at]
    c, s = linear[:, 0, 0] + linear[:, 1, 1], linear[:, 1, 0] - linear[:, 0, 1]
    turn = np.arctan2(s, c) - _yaw_in_raster(plan.evidence.A_rc_xy)
    difference = direction[None] + 2.0 * turn[:, None] - there
    agree = np.cos(difference) * coherence.ravel()[at] * known
    return (likelihood * agree) @ weight


def _by_patch(likelihood, patches) -> tuple[Array, Array]:
    sizes = np.bincount(patches.of_wall, minlength=patches.count).astype(np.float64)
    sums = np.stack([np.bincount(patches.of_wall, row, minlength=patches.count) for row in likelihood])
    return sums / np.maximum(sizes, 1.0), sizes


def _undone(shift_cells: Array, plan, linear: Array, sub) -> Array:
    """Return the shifts in the submap's cells that undo those in the plan's."""
    metres = shift_cells @ np.linalg.inv(plan.A_rc_xy[:, :2]).T
    in_sub = np.einsum('cij,cbj->cbi', np.linalg.inv(linear), metres)
    return -in_sub @ sub.A_rc_xy[:, :2].T


_label_fields: dict[int, tuple] = {}


def _coarse_labels(plan) -> NDArray[np.int32]:
    key = id(plan.segmentation)
    if key not in _label_fields:
        if len(_label_fields) > 64:
            _label_fields.clear()
        e = plan.evidence
        step = round(e.cell_m / e.resolution_m)
        first = (step - 1) // 2
        coarse = np.ascontiguousarray(plan.segmentation.labels[first::step, first::step])
        _label_fields[key] = (plan.segmentation, coarse)
    return _label_fields[key][1]


def _rooms(plan, sub, to_plan, free, scale) -> dict[str, Array]:
    count = len(to_plan)
    zero = {name: np.zeros(count) for name in ('rooms_pure', 'plan_rooms_pure', 'rooms_alike')}
    zero |= {name: np.zeros(count) for name in ('rooms_complete', 'plan_share')}
    segmentation: Segmentation = sub.segmentation
    if not len(free):
        return zero
    plan_rooms = int(plan.segmentation.labels.max()) + 1
    sub_rooms = int(segmentation.labels.max()) + 1
    rc = np.rint(segmentation.grid.xy_to_rc(free)).astype(np.int64)
    rc = np.clip(rc, 0, np.array(segmentation.labels.shape) - 1)
    of_free = segmentation.labels[rc[:, 0], rc[:, 1]].astype(np.int64)
    labels = kernels.look_up_labels(to_plan, free, _coarse_labels(plan))
    counts = kernels.room_overlap(labels, of_free, sub_rooms, plan_rooms)
    per_m2 = len(free) / max(sub.evidence.free_area_m2, 1e-6)
    inner = counts[:, 1:, 1:]
    in_sub = counts[:, 1:].sum(axis=2)
    out = dict(zero)
    if inner.shape[1] and inner.shape[2]:
        out['rooms_pure'] = inner.max(axis=2).sum(axis=1) / np.maximum(in_sub.sum(axis=1), 1.0)
        both = np.maximum(inner.sum(axis=(1, 2)), 1.0)
        out['plan_rooms_pure'] = inner.max(axis=1).sum(axis=1) / both
        area = np.zeros(plan_rooms)
        for room in plan.segmentation.rooms:
            area[room.id + 1] = room.area_m2
        whole = np.array(
            [r.id + 1 for r in segmentation.rooms if r.observed_fraction >= _WELL_SEEN], np.int64
        )
        if len(whole):
            mine = counts[:, whole][:, :, 1:]
            size = counts[:, whole].sum(axis=2)
            drawn = area[1:][None] * per_m2 / (scale**2)[:, None]
            iou = mine / np.maximum(size[:, :, None] + drawn[:, None] - mine, 1.0)
            best = iou.max(axis=2)
            out['rooms_alike'] = (best * size).sum(axis=1) / np.maximum(size.sum(axis=1), 1.0)
            out['rooms_complete'] = np.full(count, np.log1p(len(whole)))
        touched = (inner.sum(axis=1) > 0.3 * area[1:] * per_m2 / (scale**2)[:, None]) @ area[1:]
        out['plan_share'] = touched / max(area.sum(), 1e-6)
    return out


def _midpoints(segmentation: Segmentation) -> Array:
    return np.array([p.ends.mean(axis=0) for p in segmentation.portals]).reshape(-1, 2)


def _doors(plan, sub, linear, translation, to_sub) -> dict[str, Array]:
    count = len(linear)
    mine, drawn = _midpoints(sub.segmentation), _midpoints(plan.segmentation)
    out = {'doors_counted': np.full(count, np.log1p(len(mine)))}
    if not (len(mine) and len(drawn)):
        return out | {n: np.zeros(count) for n in ('doors_met', 'doors_near', 'doors_missing')}
    placed = mine @ linear.transpose(0, 2, 1) + translation[:, None]
    apart = np.linalg.norm(placed[:, :, None] - drawn[None, None], axis=3)
    nearest = apart.min(axis=2)
    out['doors_met'] = np.exp(-0.5 * (nearest / _DOOR_NEAR_M) ** 2).mean(axis=1)
    out['doors_near'] = (nearest < _DOOR_FAR_M).mean(axis=1)
    seen = kernels.look_up(to_sub, drawn, sub.evidence.observed.astype(np.float32), 0.0) > 0.0
    missing = seen & (apart.min(axis=1) > _DOOR_FAR_M)
    out['doors_missing'] = missing.sum(axis=1) / np.maximum(seen.sum(axis=1), 1.0)
    return out


def _matches(plan, sub, linear, translation, to_plan, match: MatchResult) -> dict[str, Array]:
    count = len(linear)
    out = {name: np.zeros(count) for name in ('match_rooms', 'match_doors', 'match_whole')}
    regions = sub.segmentation.regions
    if match.probability.size and regions:
        p = np.log10(np.maximum(match.probability, _LEAST_PROBABILITY)) + 3.0
        rooms = [r for r in regions if r.label is RegionLabel.ROOM]
        if rooms:
            at = np.array([r.centroid for r in rooms])
            label = kernels.look_up_labels(to_plan, at, _coarse_labels(plan)) - 1
            ids = np.array([r.id for r in rooms])
            out['match_rooms'] = np.where(label >= 0, p[np.maximum(label, 0), ids[None]], 0.0).mean(axis=1)
        mine, drawn = _midpoints(sub.segmentation), _midpoints(plan.segmentation)
        if len(mine) and len(drawn):
            placed = mine @ linear.transpose(0, 2, 1) + translation[:, None]
            apart = np.linalg.norm(placed[:, :, None] - drawn[None, None], axis=3)
            near = apart.argmin(axis=2)
            doors = np.array([q.door for q in plan.segmentation.portals])
            ids = np.array([q.door for q in sub.segmentation.portals])
            value = p[doors[near], ids[None]] * (apart.min(axis=2) < _DOOR_FAR_M)
            out['match_doors'] = value.mean(axis=1)
    corners = sub.evidence.corners
    placed = corners @ linear.transpose(0, 2, 1) + translation[:, None]
    for h in match.hypotheses:
        moved = np.linalg.norm(h.S_plan_sub.apply(corners) - placed, axis=2).mean(axis=1)
        out['match_whole'] = np.maximum(out['match_whole'], h.probability * (moved < _SAME_M))
    return out


def _rivals(out, likelihood, bent, metres) -> dict[str, Array]:
    count = len(likelihood)
    names = ('rival_net', 'rival_net_bent', 'rival_z', 'rival_contested', 'rival_score')
    names += ('rival_bent_score', 'rival_doors', 'rival_rooms', 'rival_match', 'rival_denied')
    if count == 1:
        alone = {name: np.zeros(1) for name in names}
        return alone | {'rival_score': out['score'], 'rival_bent_score': out['bent_score']}
    net, total = kernels.contested(likelihood)
    bent_net, _ = kernels.contested(bent)
    other = ~np.eye(count, dtype=np.bool_)
    worst = np.where(other, bent_net, np.inf).argmin(axis=1)
    rows = np.arange(count)

    def against(values):
        return values - np.where(other, values[None], -np.inf).max(axis=1)

    n, nb, t = net[rows, worst], bent_net[rows, worst], total[rows, worst]
    signed = lambda v: np.sign(v) * np.log1p(np.abs(v) * metres)  # noqa: E731
    return {
        'rival_net': signed(n), 'rival_net_bent': signed(nb),
        'rival_z': nb * metres / np.sqrt(t * metres + 1.0),
        'rival_contested': np.log1p(t * metres),
        'rival_score': against(out['score']), 'rival_bent_score': against(out['bent_score']),
        'rival_doors': out['doors_met'] - out['doors_met'][worst],
        'rival_rooms': against(out['rooms_pure']),
        'rival_match': against(out['match_rooms'] + out['match_doors']),
        'rival_denied': out['denied_m'] - out['denied_m'][worst],
    }  # fmt: skip
