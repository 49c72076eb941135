# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Leaves of doors that are drawn half open, without an arc.

A thin line that hangs at the end of a wall and ends freely, with a gap beside it that is as wide
as it is long, and a wall that begins beyond: a leaf is a line, and walls are none. Used by
:mod:`fpnet_core.segmentation.strokes`, which says what ``lines`` and ``ink`` are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Lengths = NDArray[np.int64]
Codes = NDArray[np.uint8]
"""Squared distances (H, W) to the nearest cell that is drawn, see ``near_code``."""

NEAR = 2
"""How far ink may lie from where a symbol says, at most [cells squared]. Chosen."""

FLANK = 3.0
"""Leaves and arcs have nothing beside them, so far away [cells]. Chosen."""

LEAF = (0.35, 0.45, 0.55, 0.65, 0.75)
"""Where leaves are looked at, as shares of their length. Chosen."""

REACH = 1.2
"""
Given: nothing that is looked at is farther from a tip than so many lengths of the leaf and
:data:`FLANK` cells; the wall behind the hinge is the farthest.
"""

MAX_BEND = 0.45
"""How far leaves without an arc may be off on average [cells]. Chosen."""

# Chosen, not measured:
_AJAR_DEG = (45.0, 30.0)  # leaves are drawn open by about so much
_LEAST_CELLS = 12  # shorter ones are not told from the ends of thin walls
# Of a leaf's length, where the gap is blank, and so far beside it on both sides.
_GAP, _GAP_SIDE = (0.2, 0.4, 0.6, 0.8), 0.2
# A leaf's length from its hinge, about, another wall begins; walls go on for so much of it.
_JAMB, _WALL = (1.0, 0.95, 1.05, 1.1, 1.15), (0.08, 0.16, 0.24)
_WITHIN = (0.0, 1.5, 3.0)  # a leaf hangs at a wall's face, or so far within it [cells]
_ACROSS = 2  # a leaf's thickness is counted so far to both sides [cells]
# No line goes on from the tip in these directions, as an arc would whose chord is taken.
_BEYOND_DEG = (-75.0, -50.0, -25.0, 0.0, 25.0, 50.0, 75.0)


def at(values: Codes, places: Array) -> Codes:
    """Return the values at the cells nearest to places (..., 2); beyond the rim, the rim's."""
    row, col = np.moveaxis((places + 0.5).astype(np.int64), -1, 0)
    rows, cols = values.shape
    return np.asarray(values[np.clip(row, 0, rows - 1), np.clip(col, 0, cols - 1)])


def is_end(ink: Codes, tips: Array, u: Array) -> Mask:
    """Tell whether no line goes on along ``u (N, 2)``, nor nearly so, from leaves' tips (N, 2)."""
    beyond = [at(ink, tips + FLANK * _turned(u, angle_deg)) > NEAR for angle_deg in _BEYOND_DEG]
    return np.asarray(np.logical_and.reduce(beyond))


def is_ajar(
    lines: Codes, ink: Codes, hinges: Array, u: Array, length: Lengths, beside: Array, thick: float
) -> Mask:
    """
    Tell whether lines of ``length (N,)`` from hinges along ``u (N, 2)`` are leaves half open.

    ``beside (N, K, 2)`` are places along and across one that are blank; it is at most ``thick``.
    """
    left = np.flatnonzero(length >= _LEAST_CELLS)
    left = left[_is_thin(lines, ink, hinges[left], u[left], length[left], thick)]
    is_beside = is_drawn(ink, hinges[left], u[left], _across(u[left]), beside[left])
    left = left[~is_beside.any(axis=1)]
    found = np.zeros(len(hinges), np.bool_)
    for opened in _AJAR_DEG:
        for side in (-1.0, 1.0):
            w = _turned(u[left], side * opened)
            is_gap = _is_gap(ink, hinges[left], w, length[left])
            own, w = left[is_gap], w[is_gap]
            found[own] |= _has_jambs(lines, ink, hinges[own], w, side, length[own])
    return found


def is_drawn(ink: Codes, origins: Array, u: Array, v: Array, places: Array) -> Mask:
    """Tell which ``places (..., K, 2)``, along ``u`` and ``v (..., 2)``, hold ink (..., K)."""
    along, across = places[..., :1] * u[..., None, :], places[..., 1:] * v[..., None, :]
    return np.asarray(at(ink, origins[..., None, :] + along + across) == 0)


def _across(u: Array) -> Array:
    """Return directions (N, 2) turned by a right angle."""
    return np.stack([-u[:, 1], u[:, 0]], axis=1)


def _turned(u: Array, angle_deg: float) -> Array:
    """Return directions (N, 2) turned by an angle."""
    angle = np.radians(angle_deg)
    return np.asarray(np.cos(angle) * u + np.sin(angle) * _across(u))


def _is_gap(ink: Codes, hinges: Array, w: Array, length: Lengths) -> Mask:
    """Tell whether nothing is drawn along ``w`` from hinges on, nor a little beside that."""
    along = np.repeat(_GAP, 3)
    across = np.outer(_GAP, (0.0, -_GAP_SIDE, _GAP_SIDE)).ravel()
    places = length[:, None, None] * np.stack([along, across], axis=1)
    return np.asarray(~is_drawn(ink, hinges, w, _across(w), places).any(axis=1))


def _is_thin(
    lines: Codes, ink: Codes, hinges: Array, u: Array, length: Lengths, thick: float
) -> Mask:
    """Tell whether leaves are lines throughout, ``thick`` at most."""
    places = hinges + np.array(LEAF)[:, None, None] * length[:, None] * u
    offsets = np.arange(-_ACROSS, _ACROSS + 1)[:, None, None, None]
    cells = (at(ink, places + offsets * _across(u)) == 0).sum(axis=(0, 1))
    is_line = (at(lines, places) <= NEAR).all(axis=0)
    return np.asarray(is_line & (cells <= thick * len(LEAF)))


def _has_jambs(
    lines: Codes, ink: Codes, hinges: Array, w: Array, side: float, length: Lengths
) -> Mask:
    """Tell whether a wall ends behind hinges, and one about a leaf's length before them."""
    found = np.zeros(len(hinges), np.bool_)
    for within in _WITHIN:
        # Away from the leaf, which is turned to this side by opening.
        ends = hinges + side * within * _across(w)
        own = np.flatnonzero(_is_wall(lines, ink, ends, -w, length))
        jambs = ends[own] + np.array(_JAMB)[:, None, None] * length[own, None] * w[own]
        is_jamb = (at(ink, jambs) == 0) & _is_wall(lines, ink, jambs, w[own], length[own])
        found[own] |= is_jamb.any(axis=0)
    return found


def _is_wall(lines: Codes, ink: Codes, ends: Array, along: Array, length: Lengths) -> Mask:
    """Tell whether ink goes on from ends (..., N, 2), thicker than lines are."""
    shares = np.array(_WALL).reshape(-1, *[1] * ends.ndim)
    places = ends + shares * length[:, None] * along
    return np.asarray(((at(ink, places) == 0) & (at(lines, places) != 0)).all(axis=0))
