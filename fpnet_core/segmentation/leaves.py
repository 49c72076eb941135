# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Door leaves that are drawn half open, without an arc.

Such a leaf is a thin line with one end hinged at the end of a wall and one free end. Beside it is
a gap as wide as the leaf is long, and another wall begins beyond the gap. Walls are thicker.
:mod:`fpnet_core.segmentation.strokes` uses this module and defines ``lines`` and ``ink``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Lengths = NDArray[np.int64]
Codes = NDArray[np.uint8]
"""Squared distances (H, W) to the nearest drawn cell, see ``near_code``."""

NEAR = 2
"""Largest squared distance of ink from its expected place [cells squared]. Chosen."""

FLANK = 3.0
"""Distance at which nothing may be drawn beside leaves and arcs [cells]. Chosen."""

LEAF = (0.35, 0.45, 0.55, 0.65, 0.75)
"""Sample positions on leaves, as shares of their length. Chosen."""

REACH = 1.2
"""
Given: largest distance of a sample from the tip, in lengths of the leaf; :data:`FLANK` cells come
on top. The wall behind the hinge is the farthest.
"""

MAX_BEND = 0.45
"""Largest mean deviation of leaves without an arc [cells]. Chosen."""

# Chosen, not measured:
_AJAR_DEG = (45.0, 30.0)  # approximate opening angles of drawn leaves
_LEAST_CELLS = 12  # shorter ones cannot be told from the ends of thin walls
# Blank samples in the gap, over the leaf's length: along it, and offset to both sides.
_GAP, _GAP_SIDE = (0.2, 0.4, 0.6, 0.8), 0.2
# Distance of the opposite wall from the hinge, and samples on walls, over the leaf's length.
_JAMB, _WALL = (1.0, 0.95, 1.05, 1.1, 1.15), (0.08, 0.16, 0.24)
_WITHIN = (0.0, 1.5, 3.0)  # a leaf is hinged at a wall's face or this far inside it [cells]
_ACROSS = 2  # reach on both sides when a leaf's thickness is counted [cells]
# No line may continue from the tip in these directions; the chord of an arc would.
_BEYOND_DEG = (-75.0, -50.0, -25.0, 0.0, 25.0, 50.0, 75.0)


def at(values: Codes, places: Array) -> Codes:
    """Return the values at the cells nearest to places (..., 2), clamped to the edge."""
    row, col = np.moveaxis((places + 0.5).astype(np.int64), -1, 0)
    rows, cols = values.shape
    return np.asarray(values[np.clip(row, 0, rows - 1), np.clip(col, 0, cols - 1)])


def is_end(ink: Codes, tips: Array, u: Array) -> Mask:
    """Return whether no line continues from tips (N, 2) roughly along ``u (N, 2)``."""
    beyond = [at(ink, tips + FLANK * _turned(u, angle_deg)) > NEAR for angle_deg in _BEYOND_DEG]
    return np.asarray(np.logical_and.reduce(beyond))


def is_ajar(
    lines: Codes, ink: Codes, hinges: Array, u: Array, length: Lengths, beside: Array, thick: float
) -> Mask:
    """
    Return whether lines of ``length (N,)`` from hinges along ``u (N, 2)`` are half-open leaves.

    ``beside (N, K, 2)`` are offsets that must be blank; ``thick`` is the largest thickness.
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
    """Return which ``places (..., K, 2)``, along ``u`` and ``v (..., 2)``, hold ink (..., K)."""
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
    """Return whether nothing is drawn along ``w`` from the hinges, nor slightly beside it."""
    along = np.repeat(_GAP, 3)
    across = np.outer(_GAP, (0.0, -_GAP_SIDE, _GAP_SIDE)).ravel()
    places = length[:, None, None] * np.stack([along, across], axis=1)
    return np.asarray(~is_drawn(ink, hinges, w, _across(w), places).any(axis=1))


def _is_thin(
    lines: Codes, ink: Codes, hinges: Array, u: Array, length: Lengths, thick: float
) -> Mask:
    """Return whether leaves are lines throughout, at most ``thick``."""
    places = hinges + np.array(LEAF)[:, None, None] * length[:, None] * u
    offsets = np.arange(-_ACROSS, _ACROSS + 1)[:, None, None, None]
    cells = (at(ink, places + offsets * _across(u)) == 0).sum(axis=(0, 1))
    is_line = (at(lines, places) <= NEAR).all(axis=0)
    return np.asarray(is_line & (cells <= thick * len(LEAF)))


def _has_jambs(
    lines: Codes, ink: Codes, hinges: Array, w: Array, side: float, length: Lengths
) -> Mask:
    """Return whether a wall ends at the hinge and another about a leaf's length away."""
    found = np.zeros(len(hinges), np.bool_)
    for within in _WITHIN:
        # The offset points away from the leaf, which opens to the other side.
        ends = hinges + side * within * _across(w)
        own = np.flatnonzero(_is_wall(lines, ink, ends, -w, length))
        jambs = ends[own] + np.array(_JAMB)[:, None, None] * length[own, None] * w[own]
        is_jamb = (at(ink, jambs) == 0) & _is_wall(lines, ink, jambs, w[own], length[own])
        found[own] |= is_jamb.any(axis=0)
    return found


def _is_wall(lines: Codes, ink: Codes, ends: Array, along: Array, length: Lengths) -> Mask:
    """Return whether ink continues from ends (..., N, 2), thicker than lines."""
    shares = np.array(_WALL).reshape(-1, *[1] * ends.ndim)
    places = ends + shares * length[:, None] * along
    return np.asarray(((at(ink, places) == 0) & (at(lines, places) != 0)).all(axis=0))
