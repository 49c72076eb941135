# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evidence from walls and free space: observations against the plan, and the plan against them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Placements
from fpnet_core.geometry.distinct import evenly_drawn
from fpnet_core.pose import MapEvidence, PreparedMap
from fpnet_core.pose.verify import OUTSIDE_FULL_M, OUTSIDE_TOLERANCE_M
from fpnet_core.raster.rays import cells_at
from fpnet_core.scoring import kernels
from fpnet_core.scoring.deform import WIDTH_M, Deformation, Patches, deform, patches_of

Array = NDArray[np.float64]
Figures = dict[str, Array]

_MAX_WALLS, _MAX_FREE, _MAX_DRAWN = 900, 700, 3000
"""Evenly spread samples of either map; numerical: twice as many change no feature by more than a
hundredth."""

_FINE_M, _WIDE_M = 0.5 * WIDTH_M, 2.0 * WIDTH_M
BEYOND_M = 3.0
"""
Distance assigned to a wall with no plan wall nearby; larger distances count the same. Chosen.
"""

_BEYOND = np.float32(BEYOND_M)
# Chosen, not measured:
_RESIDUALS = (50, 75, 90)  # percentiles of the distance used as features
_ON_WALL_M = 0.1  # one cell: free space this near to a plan wall was crossed by a beam
_SEEN_EDGES_M = np.array([0.15, 0.3, 0.6])  # fine, seen, neither; beyond: contradicted
_PATCH_EXPLAINED = 0.35  # patches with a lower share of walls on plan walls are unexplained


@dataclass(frozen=True, eq=False)
class LookedAt:
    """
    Samples of the submap under each of ``C`` placements.

    ``walls (P, 2)`` and ``free (F, 2)`` are samples [m], a wall sample represents ``metres``;
    ``straight (P,)`` is the straightness of its wall, ``normal (P,)`` twice the direction of its
    normal in the raster's axes [rad]. ``to_plan`` and ``to_sub (C, 2, 3)`` map
    metres of one map to the raster of the other. ``distance (C, P)`` is that to the nearest
    plan wall [m], in the raster's ``cell (C, P)``, and ``bent_distance`` the same on the deformed
    plan.
    """

    walls: Array
    free: Array
    metres: float
    straight: NDArray[np.float32]
    normal: NDArray[np.float32]
    to_plan: Array
    to_sub: Array
    patches: Patches
    bent: Deformation
    distance: NDArray[np.float32]
    bent_distance: NDArray[np.float32]
    cell: NDArray[np.int64]

    @property
    def likelihood(self) -> NDArray[np.float32]:
        """Likelihood of each wall sample on the plan, ``(C, P)``."""
        return kernel(self.distance, WIDTH_M)

    @property
    def bent_likelihood(self) -> NDArray[np.float32]:
        """The same on the deformed plan."""
        return kernel(self.bent_distance, WIDTH_M)


def look_at(plan: MapEvidence, sub: MapEvidence, placements: Placements) -> LookedAt:
    """Return the samples of a submap with walls under ``C > 0`` placements."""
    walls, free, patches = sub.kept(_samples)
    to_plan = _chained(plan.A_rc_xy, placements.linear, placements.translation)
    inverse = np.asarray(np.linalg.inv(placements.linear), dtype=np.float64)
    back = -np.einsum('cij,cj->ci', inverse, placements.translation)
    bent = deform(plan, to_plan, walls, patches)
    field = plan.wall_distance
    cell = kernels.cells_under(to_plan, walls, field.shape)
    moved = kernels.cells_under(to_plan, walls, field.shape, (bent.shift_cells, patches.of_wall))
    distance, bent_distance = (kernels.looked_up(under, field, _BEYOND) for under in (cell, moved))
    straight, normal = sub.straightness_at(_cells_under(sub, walls))
    return LookedAt(
        walls=walls,
        free=free,
        metres=sub.wall_length_m / len(walls),
        straight=straight,
        normal=normal,
        to_plan=to_plan,
        to_sub=_chained(sub.A_rc_xy, inverse, back),
        patches=patches,
        bent=bent,
        distance=distance,
        bent_distance=bent_distance,
        cell=cell,
    )


def _samples(sub: MapEvidence) -> tuple[Array, Array, Patches]:
    """Return samples of a submap's walls (P, 2) and free space (F, 2), and its patches."""
    walls = evenly_drawn(sub.walls, _MAX_WALLS)
    return walls, evenly_drawn(sub.free, _MAX_FREE), patches_of(walls, sub)


def wall_figures(
    plan: PreparedMap, sub: PreparedMap, placements: Placements, looked: LookedAt
) -> Figures:
    """Return the features of walls and free space, ``(C,)`` each."""
    return (
        _forward(looked)
        | _straight(plan.evidence, sub.evidence, placements, looked)
        | _unexplained(looked)
        | _bent(looked)
        | _backward(plan.evidence, sub.evidence, placements, looked)
        | _free(plan.evidence, sub.evidence, looked)
    )


def kernel(distance: NDArray[np.float32], width_m: float) -> NDArray[np.float32]:
    """Return ``exp(-d^2 / (2 width^2))``."""
    return np.asarray(np.exp(-0.5 * np.square(distance / np.float32(width_m))), np.float32)


def _chained(A_rc_xy: Array, linear: Array, translation: Array) -> Array:
    """Return ``(C, 2, 3)``: metres of one map to the raster of the other."""
    moved = translation @ A_rc_xy[:, :2].T + A_rc_xy[:, 2]
    return np.concatenate([A_rc_xy[:, :2] @ linear, moved[:, :, None]], axis=2)


def _cells_under(side: MapEvidence, points: Array) -> NDArray[np.int64]:
    """Return the flat indices ``(P,)`` of the raster's cells nearest to ``points (P, 2)``."""
    rows, cols = cells_at(points @ side.A_rc_xy[:, :2].T + side.A_rc_xy[:, 2], side.observed.shape)
    return np.asarray(rows * side.observed.shape[1] + cols)


def _forward(looked: LookedAt) -> Figures:
    widths = {'support_fine': _FINE_M, 'support': WIDTH_M, 'support_wide': _WIDE_M}
    supports = {name: _mean(kernel(looked.distance, width)) for name, width in widths.items()}
    residuals = np.percentile(looked.distance.astype(np.float64), _RESIDUALS, axis=1)
    named = zip(_RESIDUALS, residuals, strict=True)
    return supports | {f'residual_{percent}': value for percent, value in named}


def _mean(values: NDArray[np.float32]) -> Array:
    """Return the mean over the samples of each placement."""
    return np.asarray(values.mean(axis=1), dtype=np.float64)


def _straight(
    plan: MapEvidence, sub: MapEvidence, placements: Placements, looked: LookedAt
) -> Figures:
    """Return the support of straight walls, also by plan walls of the same direction."""
    likelihood, weight = looked.likelihood.astype(np.float64), looked.straight
    total = max(float(weight.sum()), 1e-6)
    coherence, normal = (field.ravel() for field in plan.straightness)
    is_on_plan = looked.cell >= 0
    at = np.where(is_on_plan, looked.cell, 0)
    # Twice the angle, because a wall normal has no sign.
    turn = placements.heading + _axis_yaw(sub) - _axis_yaw(plan)
    agrees = np.cos(looked.normal + 2.0 * turn[:, None] - normal[at]) * coherence[at] * is_on_plan
    return {
        # No BLAS: its threads would wait for each other over so few numbers.
        'straight_support': np.einsum('cp,p->c', likelihood, weight) / total,
        'straight_aligned': np.einsum('cp,cp,p->c', likelihood, agrees, weight) / total,
    }


def _axis_yaw(side: MapEvidence) -> float:
    """Return the direction of the raster's columns in metres [rad]."""
    along = np.linalg.inv(side.A_rc_xy[:, :2])[:, 1]
    return float(np.arctan2(along[1], along[0]))


def _unexplained(looked: LookedAt) -> Figures:
    """Return wall in unexplained patches: clutter is scattered, a wrong place is contiguous."""
    of_wall, count = looked.patches.of_wall, looked.patches.count
    size = np.bincount(of_wall, minlength=count)
    support = np.stack([np.bincount(of_wall, row, minlength=count) for row in looked.likelihood])
    walls = ((support < _PATCH_EXPLAINED * size) * size).sum(axis=1)
    return {
        'patches_unexplained': walls / size.sum(),
        'unexplained_m': np.log1p(walls * looked.metres),
    }


def _bent(looked: LookedAt) -> Figures:
    support = _mean(looked.bent_likelihood)
    bent = looked.bent
    return {
        'bent_support': support,
        'bent_support_fine': _mean(kernel(looked.bent_distance, _FINE_M)),
        'bend_m': bent.size_m,
        'bend_rough_m': bent.roughness_m,
        'bend_gain': support - _mean(looked.likelihood),
        'contrast_mean': bent.contrast_mean,
        'contrast_least': bent.contrast_least,
    }


def _backward(
    plan: MapEvidence, sub: MapEvidence, placements: Placements, looked: LookedAt
) -> Figures:
    """Return the shares of plan walls in the observed area that are confirmed or contradicted."""
    drawn = evenly_drawn(plan.walls, _MAX_DRAWN)
    drawn_m = plan.wall_length_m / max(len(drawn), 1)
    plain, bent = kernels.drawn_walls(
        looked.to_sub, drawn, sub.wall_distance, sub.observed, looked.patches.of_cell,
        _undone(looked.bent.shift_cells, plan, placements, sub), _SEEN_EDGES_M,
    )  # fmt: skip
    count = np.maximum(plain.sum(axis=1), 1.0)
    return {
        'seen_fine': plain[:, 0] / count,
        'seen': plain[:, :2].sum(axis=1) / count,
        'denied': plain[:, 3] / count,
        'denied_m': np.log1p(plain[:, 3] * drawn_m),
        'bent_seen': bent[:, :2].sum(axis=1) / count,
        'bent_denied': bent[:, 3] / count,
    }


def _undone(
    shift_cells: Array, plan: MapEvidence, placements: Placements, sub: MapEvidence
) -> Array:
    """Return the inverse of the shifts in the plan, ``(C, B, 2)`` in the submap's cells."""
    metres = shift_cells @ np.linalg.inv(plan.A_rc_xy[:, :2]).T
    in_sub = np.einsum('cij,cbj->cbi', np.linalg.inv(placements.linear), metres)
    return np.asarray(-in_sub @ sub.A_rc_xy[:, :2].T)


def _free(plan: MapEvidence, sub: MapEvidence, looked: LookedAt) -> Figures:
    """Return the shares of free space outside the building and on plan walls."""
    if not len(looked.free):
        nothing = np.zeros(len(looked.to_plan))
        return {'outside': nothing, 'outside_m2': nothing, 'on_wall': nothing}
    depth = kernels.look_up(looked.to_plan, looked.free, plan.outside_depth, _BEYOND)
    share = (depth - OUTSIDE_TOLERANCE_M) / (OUTSIDE_FULL_M - OUTSIDE_TOLERANCE_M)
    outside = np.clip(share, 0.0, 1.0).mean(axis=1)
    near = kernels.look_up(looked.to_plan, looked.free, plan.wall_distance, _BEYOND)
    return {
        'outside': outside,
        'outside_m2': np.log1p(outside * sub.free_area_m2),
        'on_wall': (near <= _ON_WALL_M).mean(axis=1),
    }
