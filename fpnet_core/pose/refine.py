# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Robust alignment of the submap's walls with the plan's, over pose and anisotropic scale.

A candidate is ``A_plan_submap = (I + E) S R`` with rotation ``R``, stretch ``S`` of the drawing
and a small symmetric strain ``E`` of the drawing (exx, eyy, exy). ``S`` is the known stretch of
the drawing, else the candidate's own mean scale. A strain that a candidate already has counts as
strain, so repeated refinement does not relax the prior. The solver is Gauss-Newton with a Welsch
weight on the plan's wall distance, whose width is annealed from coarse to fine; a Gaussian prior
keeps the strain small where walls do not determine it. :data:`STRAIN_LIMIT` bounds it, because
with enough strain any corridor fits any other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import unwritable
from fpnet_core.geometry import Placements
from fpnet_core.pose.evidence import MapEvidence

Array = NDArray[np.float64]

STRAIN_LIMIT = 3.0
"""Largest component of the strain, in its standard deviations. Chosen."""

_STEPS_PER_WIDTH = 3  # numerical
_DAMPING = 1e-6  # numerical: keeps the system solvable without walls nearby
_POINT_SIGMA_M = 0.15  # standard deviation of one drawn wall sample, for the covariance; chosen


@dataclass(frozen=True)
class SolverSchedule:
    """
    Effort of a refinement.

    ``widths_m`` are the Welsch kernel's, coarse to fine; at most ``max_points`` walls are used.
    """

    widths_m: tuple[float, ...]
    max_points: int


ROUGH = SolverSchedule((0.8, 0.5, 0.3), 200)
"""For new candidates of a known scale, until their scores can be compared. Chosen."""

NEAR = SolverSchedule((0.4, 0.3), 200)
"""
For the candidates of a search: on small maps with few walls, a wider kernel diverges. Right on
the development pairs of 20-35 and 10-20 %: 93 and 79 %, with ``ROUGH`` first 92 and 77 %. Chosen.
"""

FINE = SolverSchedule((0.3, 0.2, 0.15), 800)
"""For the final refinement of candidates that are close. Chosen."""

AGAIN = SolverSchedule((0.5, 0.3, 0.2), 600)
"""For tracking a placement with an error below half a metre. Chosen."""

RIGID_STRAIN = 1e-4
"""Chosen: of :class:`AlignmentPrior`, if too little is observed to estimate the stretch."""


@dataclass(frozen=True, eq=False)
class AlignmentPrior:
    """
    Prior on the drawing's stretch during refinement.

    ``anisotropy_sigma`` is the standard deviation of the drawing's anisotropic scale, 0.03 for
    "a few percent".
    It is relative to ``stretch (2, 2)``, symmetric, plan metres per submap metre, if that is
    known, else to each candidate's mean scale, which stays within ``scales``.
    """

    anisotropy_sigma: float
    stretch: Array | None = None
    scales: tuple[float, float] = (0.0, np.inf)


def refine(
    plan: MapEvidence,
    walls: Array,
    candidates: Placements,
    alignment_prior: AlignmentPrior,
    schedule: SolverSchedule,
) -> Placements:
    """
    Align candidates with the plan's walls: similarity times a small strain.

    Parameters
    ----------
    plan : evidence of the drawing
    walls : (P, 2) samples of the submap's walls [m]
    candidates : initial placements
    alignment_prior : prior on the stretch of the drawing
    schedule : ``NEAR`` or ``ROUGH`` for many candidates, ``FINE`` for few that are close

    Returns
    -------
    As many placements in the same order, with covariances, not yet scored.
    """
    points = np.ascontiguousarray(walls[:: max(1, -(-len(walls) // schedule.max_points))])
    if not len(points):
        cov = np.zeros((len(candidates), 3, 3))
        return Placements(candidates.linear, candidates.translation, cov=cov)
    mid = points.mean(axis=0)
    start, strain = _split_strain(candidates.linear, alignment_prior.stretch)
    bounds = np.array(alignment_prior.scales) / np.sqrt(np.abs(np.linalg.det(start)))[:, None]
    centre = candidates.linear @ mid + candidates.translation
    params = np.zeros(
        (len(candidates), 6)
    )  # dx, dy of the centre [m], rotation [rad], exx, eyy, exy
    params[:, 3:] = strain
    H = np.tile(np.eye(6), (len(params), 1, 1))
    _align(
        params, H, start, centre, bounds, STRAIN_LIMIT * alignment_prior.anisotropy_sigma,
        np.ascontiguousarray((points - mid).T), unwritable(plan.wall_distance),
        unwritable(plan.A_rc_xy), np.repeat(schedule.widths_m, _STEPS_PER_WIDTH),
        np.repeat([0.0, (_POINT_SIGMA_M / alignment_prior.anisotropy_sigma) ** 2], 3),
        np.empty((8, len(points))), np.empty((7, 6)),
    )  # fmt: skip
    linear = _strained(params, start)
    lever = linear @ mid
    # Covariance of x, y and yaw, transferred from the samples' centroid to the submap's origin.
    moved = np.tile(np.eye(3), (len(params), 1, 1))
    moved[:, 0, 2], moved[:, 1, 2] = lever[:, 1], -lever[:, 0]
    cov = moved @ (_POINT_SIGMA_M**2 * np.linalg.inv(H)[:, :3, :3]) @ moved.swapaxes(1, 2)
    return Placements(linear, centre + params[:, :2] - lever, cov=cov)


def _split_strain(linear: Array, stretch: Array | None) -> tuple[Array, Array]:
    """Return ``S R (C, 2, 2)`` without strain, and the strains (C, 3) that restore ``linear``."""
    turned = linear[:, 1, 0] - linear[:, 0, 1], linear[:, 0, 0] + linear[:, 1, 1]
    yaw = np.arctan2(*turned)
    cs, sn = np.cos(yaw), np.sin(yaw)
    R = np.stack([cs, -sn, sn, cs], axis=1).reshape(-1, 2, 2)
    if stretch is None:
        start = np.sqrt(np.linalg.det(linear))[:, None, None] * R
    else:
        start = np.asarray(stretch) @ R
    E = linear @ np.linalg.inv(start)
    strain = [E[:, 0, 0] - 1.0, E[:, 1, 1] - 1.0, 0.5 * (E[:, 0, 1] + E[:, 1, 0])]
    return np.ascontiguousarray(start), np.stack(strain, axis=1)


def _strained(params: Array, start: Array) -> Array:
    """Return the linear parts ``(I + E) R(rotation) start (C, 2, 2)``."""
    _, _, turn, exx, eyy, exy = params.T
    cs, sn = np.cos(turn), np.sin(turn)
    R = np.stack([cs, -sn, sn, cs], axis=1).reshape(-1, 2, 2)
    E = np.stack([1.0 + exx, exy, exy, 1.0 + eyy], axis=1).reshape(-1, 2, 2)
    return np.asarray(E @ (R @ start))


@numba.njit(cache=True, nogil=True)
def _align(  # type: ignore[no-untyped-def]
    params, H, start, centre, bounds, limit, offsets, field, A_rc_xy, widths, prior, memory, lower
):
    """
    Run one Gauss-Newton step per width on ``params (C, 6)`` in place.

    ``prior (6,)`` are the inverse variances, ``H (C, 6, 6)`` receives the last system of each;
    ``memory (8, P)`` and ``lower (7, 6)`` are for intermediate results.
    """
    g = lower[6]
    for c in range(len(params)):
        own, system = params[c], H[c]
        for step in range(len(widths) + 1):
            # The strain is clipped, and the mean of its stretches kept between two factors.
            mean = 1.0 + 0.5 * (own[3] + own[4])
            excess = max(mean - bounds[c, 1], 0.0) + min(mean - bounds[c, 0], 0.0)
            own[3] -= excess
            own[4] -= excess
            for a in range(3, 6):
                own[a] = min(max(own[a], -limit), limit)
            if step == len(widths):
                break
            x, y = centre[c, 0] + own[0], centre[c, 1] + own[1]
            width = widths[step]
            count = _residuals(own, start[c], x, y, offsets, field, A_rc_xy, width, memory)
            _normal_equations(memory, count, system, g)
            for a in range(6):
                system[a, a] += prior[a]
                system[a, a] += _DAMPING
                g[a] += prior[a] * own[a]
            # Cholesky factorisation; the solution replaces g.
            for i in range(6):
                for j in range(i + 1):
                    total = system[i, j]
                    for k in range(j):
                        total -= lower[i, k] * lower[j, k]
                    lower[i, j] = total / lower[j, j] if j < i else np.sqrt(total)
                for k in range(i):
                    g[i] -= lower[i, k] * g[k]
                g[i] /= lower[i, i]
            for i in range(5, -1, -1):
                for k in range(i + 1, 6):
                    g[i] -= lower[k, i] * g[k]
                g[i] /= lower[i, i]
                own[i] -= g[i]


@numba.njit(cache=True, nogil=True)
def _residuals(  # type: ignore[no-untyped-def]
    params, start, x0, y0, offsets, field, A_rc_xy, width, out
):
    """
    Fill columns of ``out (8, P)`` with Welsch weights, wall distances and their six derivatives.

    ``offsets (2, P)`` are the points relative to their centroid, which is placed at ``x0, y0``.
    Points off the field or without a slope are left out; returns the number of the others.
    """
    # The linear part (I + E) R(rotation) start.
    cs, sn = np.cos(params[2]), np.sin(params[2])
    x, u = cs * start[0, 0] - sn * start[1, 0], cs * start[0, 1] - sn * start[1, 1]
    y, v = sn * start[0, 0] + cs * start[1, 0], sn * start[0, 1] + cs * start[1, 1]
    xx, xy = (1.0 + params[3]) * x + params[5] * y, (1.0 + params[3]) * u + params[5] * v
    yx, yy = params[5] * x + (1.0 + params[4]) * y, params[5] * u + (1.0 + params[4]) * v
    # Several loops, so that the compiler can vectorise all but the second.
    for k in range(offsets.shape[1]):
        px, py = offsets[0, k], offsets[1, k]
        qx, qy = xx * px + xy * py, yx * px + yy * py
        out[0, k] = A_rc_xy[0, 0] * (qx + x0) + A_rc_xy[0, 1] * (qy + y0) + A_rc_xy[0, 2]
        out[1, k] = A_rc_xy[1, 0] * (qx + x0) + A_rc_xy[1, 1] * (qy + y0) + A_rc_xy[1, 2]
        out[2, k], out[3, k] = qx, qy
    rows, cols = field.shape
    n = 0
    for k in range(offsets.shape[1]):
        row, col = out[0, k], out[1, k]
        if row < 0 or col < 0 or row >= rows - 1 or col >= cols - 1:
            continue
        # Bilinear; a separate function would count references to the field at every call.
        r, c = int(row), int(col)
        fr, fc = row - r, col - c
        here, right = field[r, c], field[r, c + 1]
        down, across = field[r + 1, c], field[r + 1, c + 1]
        d_row = (down - here) * (1 - fc) + (across - right) * fc
        d_col = (right - here) * (1 - fr) + (across - down) * fr
        if d_row == 0.0 and d_col == 0.0:
            continue
        d = (here * (1 - fc) + right * fc) * (1 - fr) + (down * (1 - fc) + across * fc) * fr
        out[2, n], out[3, n] = out[2, k], out[3, k]
        out[0, n], out[1, n], out[4, n] = d_row, d, d_col
        n += 1
    for k in range(n):
        d_row, d_col, qx, qy = out[0, k], out[4, k], out[2, k], out[3, k]
        jx = d_row * A_rc_xy[0, 0] + d_col * A_rc_xy[1, 0]
        jy = d_row * A_rc_xy[0, 1] + d_col * A_rc_xy[1, 1]
        # To first order, strain and rotation act on the placed offset (qx, qy).
        out[2, k], out[3, k], out[4, k] = jx, jy, jy * qx - jx * qy
        out[5, k], out[6, k], out[7, k] = jx * qx, jy * qy, jx * qy + jy * qx
    for k in range(n):
        d = out[1, k]
        out[0, k] = np.exp(-0.5 * d * d / (width * width))
    return n


@numba.njit(cache=True, nogil=True, fastmath={'reassoc', 'contract'})
def _normal_equations(residuals, count, H, g):  # type: ignore[no-untyped-def]
    """
    Write the Gauss-Newton system (6, 6), (6,) of the first columns of :func:`_residuals`.

    ``fastmath`` allows any order of summation, so that the loop is vectorised.
    """
    weight, d = residuals[0], residuals[1]
    j0, j1, j2 = residuals[2], residuals[3], residuals[4]
    j3, j4, j5 = residuals[5], residuals[6], residuals[7]
    for a in range(6):
        own = residuals[2 + a]
        total = h0 = h1 = h2 = h3 = h4 = h5 = 0.0
        for k in range(count):
            w = weight[k] * own[k]
            total += w * d[k]
            h0, h1, h2 = h0 + w * j0[k], h1 + w * j1[k], h2 + w * j2[k]
            h3, h4, h5 = h3 + w * j3[k], h4 + w * j4[k], h5 + w * j5[k]
        g[a] = total
        H[a, 0], H[a, 1], H[a, 2] = h0, h1, h2
        H[a, 3], H[a, 4], H[a, 5] = h3, h4, h5
