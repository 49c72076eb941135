# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Leaves of doors that are drawn half open, without an arc.

A thin line that hangs at the end of a wall and ends freely, with a gap beside it that is as wide
as it is long, and a wall that begins beyond: a leaf is a line, and walls are none. Kernels of
:mod:`fpnet_core.segmentation.strokes`, which says what ``lines`` and ``ink`` are.
"""

from __future__ import annotations

from numba import njit
import numpy as np

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


@njit(cache=True, nogil=True, inline='always')
def at(values, row, col):  # type: ignore[no-untyped-def]
    """Return the value at the cell nearest to a place, counted from the padding's corner."""
    return values[int(row + 0.5), int(col + 0.5)]


@njit(cache=True, nogil=True)
def is_end(ink, row, col, u):  # type: ignore[no-untyped-def]
    """Tell whether no line goes on along ``u``, nor nearly so, from a leaf's tip."""
    for angle_deg in _BEYOND_DEG:
        v = _turned(u, angle_deg)
        if at(ink, row + FLANK * v[0], col + FLANK * v[1]) <= NEAR:
            return False
    return True


@njit(cache=True, nogil=True)
def is_ajar(lines, ink, hinge, u, length, beside, thick):  # type: ignore[no-untyped-def]
    """
    Tell whether a line of ``length`` from a hinge along ``u`` is a leaf that stands half open.

    ``beside (K, 2)`` are places along and across it that are blank; it is at most ``thick``.
    """
    if length < _LEAST_CELLS:
        return False
    for opened in _AJAR_DEG:
        for side in (-1.0, 1.0):
            w = _turned(u, side * opened)
            if (
                _is_gap(ink, hinge, w, length)
                and _has_jambs(lines, ink, hinge, w, side, length)
                and _is_thin(lines, ink, hinge, u, length, thick)
                and _is_blank_beside(ink, hinge, u, beside)
            ):
                return True
    return False


@njit(cache=True, nogil=True)
def _turned(u, angle_deg):  # type: ignore[no-untyped-def]
    """Return a direction turned by an angle."""
    cs, sn = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return u[0] * cs - u[1] * sn, u[0] * sn + u[1] * cs


@njit(cache=True, nogil=True)
def _is_gap(ink, hinge, w, length):  # type: ignore[no-untyped-def]
    """Tell whether nothing is drawn along ``w`` from a hinge on, nor a little beside that."""
    for share in _GAP:
        for side in (0.0, -_GAP_SIDE, _GAP_SIDE):
            row = hinge[0] + length * share * (w[0] - side * w[1])
            col = hinge[1] + length * share * (w[1] + side * w[0])
            if at(ink, row, col) == 0:
                return False
    return True


@njit(cache=True, nogil=True)
def _is_blank_beside(ink, hinge, u, beside):  # type: ignore[no-untyped-def]
    """Tell whether none of ``beside (K, 2)``, along and across a leaf, is drawn."""
    for a, b in beside:
        if at(ink, hinge[0] + a * u[0] - b * u[1], hinge[1] + a * u[1] + b * u[0]) == 0:
            return False
    return True


@njit(cache=True, nogil=True)
def _is_thin(lines, ink, hinge, u, length, thick):  # type: ignore[no-untyped-def]
    """Tell whether a leaf is a line throughout, ``thick`` at most."""
    cells = 0
    for share in LEAF:
        row, col = hinge[0] + share * length * u[0], hinge[1] + share * length * u[1]
        if at(lines, row, col) > NEAR:
            return False
        for offset in range(-_ACROSS, _ACROSS + 1):
            cells += at(ink, row - offset * u[1], col + offset * u[0]) == 0
    return cells <= thick * len(LEAF)


@njit(cache=True, nogil=True)
def _has_jambs(lines, ink, hinge, w, side, length):  # type: ignore[no-untyped-def]
    """Tell whether a wall ends behind a hinge, and one about a leaf's length before it."""
    for within in _WITHIN:
        # Away from the leaf, which is turned to this side by opening.
        end = (hinge[0] - side * within * w[1], hinge[1] + side * within * w[0])
        if not _is_wall(lines, ink, end, (-w[0], -w[1]), length):
            continue
        for share in _JAMB:
            jamb = (end[0] + share * length * w[0], end[1] + share * length * w[1])
            if at(ink, jamb[0], jamb[1]) == 0 and _is_wall(lines, ink, jamb, w, length):
                return True
    return False


@njit(cache=True, nogil=True)
def _is_wall(lines, ink, end, along, length):  # type: ignore[no-untyped-def]
    """Tell whether ink goes on from an end, thicker than lines are."""
    for share in _WALL:
        row, col = end[0] + share * length * along[0], end[1] + share * length * along[1]
        if at(ink, row, col) != 0 or at(lines, row, col) == 0:
            return False
    return True
