# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Unit of a CAD file: the stated one, checked against doors, walls and size.

Many files state a wrong unit: a template's millimetres stay in the header of a drawing in
metres. The units in use differ by a factor of 2.5 or more, so that few doors identify the unit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
import math

import numpy as np

from fpnet_core.drawings.formats.doors import find_doors
from fpnet_core.drawings.formats.pages import Array, OutlinePieces
from fpnet_core.drawings.lengths import FOOT_M, INCH_M

UNITS_M = {'mm': 0.001, 'cm': 0.01, 'm': 1.0, 'inch': INCH_M, 'foot': FOOT_M}
"""Length of the units that buildings are drawn in [m]. Physical: by definition."""

# Chosen, not measured:
_PRIOR = {
    'mm': 0.45,
    'cm': 0.15,
    'm': 0.25,
    'inch': 0.1,
    'foot': 0.05,
}  # of files that state no unit
_STATED = 0.9  # of files state the right unit
_SURE = 0.95  # smallest probability of an accepted unit
# Typical length [m], spread of its logarithm, and largest penalty of a unit [nats].
_DOOR = (0.9, 0.22, 10.0)  # width of a leaf
_WALL = (0.17, 0.55, 3.0)  # thickness of a wall
_BUILDING = (40.0, 1.1, 6.0)  # long side of a building
_IMPLAUSIBLE = 5.0  # penalty of the best unit from which none of them fits [nats]
_MIN_DOORS = 2
_LONGEST = 1500  # numerical: segments compared for the thickness of walls
_PARALLEL = math.radians(1.0)
_MIN_PAIRED = 0.15  # of the line length has a parallel neighbour if walls are double lines


@dataclass(frozen=True)
class DrawingUnit:
    """A unit of a drawing: ``length_m`` [m], None if unsure; ``stated_m`` by the file."""

    length_m: float | None
    why: str = ''
    notes: tuple[str, ...] = ()
    stated_m: float | None = None


def resolve_unit(
    pieces: OutlinePieces, walls: OutlinePieces, stated_m: float | None, size: float
) -> DrawingUnit:
    """
    Return the unit of a CAD drawing; only doors can overrule the stated one.

    Parameters
    ----------
    pieces, walls : all segments, and those that may be walls
    stated_m : the unit that the file states [m], None if it states none
    size : long side of the drawing in its units
    """
    candidates = dict(_PRIOR)
    stated = next((n for n, m in UNITS_M.items() if stated_m and math.isclose(m, stated_m)), None)
    if stated is not None:
        rest = 1.0 - candidates[stated]
        candidates = {n: p * (1.0 - _STATED) / rest for n, p in candidates.items()}
        candidates[stated] = _STATED
    elif stated_m is not None:
        return DrawingUnit(stated_m, 'unit of the file header')
    doors = find_doors(pieces, None, size).width
    evidence = [(size, _BUILDING)]
    thickness = None
    if len(doors) >= _MIN_DOORS:
        evidence.append((float(np.median(doors)), _DOOR))
    else:
        thickness = wall_thickness(walls)
    if thickness is not None:
        evidence.append((thickness, _WALL))
    logs = {n: math.log(p) + _support(UNITS_M[n], evidence) for n, p in candidates.items()}
    top = max(logs.values())
    total = sum(math.exp(value - top) for value in logs.values())
    best = max(logs, key=lambda n: logs[n])
    is_plausible = _support(UNITS_M[best], evidence) > -_IMPLAUSIBLE
    unit = _unit_of(best, stated, 1.0 / total if is_plausible else 0.0, len(doors))
    return replace(unit, stated_m=stated_m)


def _unit_of(best: str, stated: str | None, probability: float, doors: int) -> DrawingUnit:
    if probability < _SURE or (best != stated and doors < _MIN_DOORS):
        statement = (
            f'states {stated}, which neither doors nor walls confirm'
            if stated
            else ('states no unit')
        )
        return DrawingUnit(None, '', (f'the file {statement}: its scale is unknown',))
    if best == stated:
        return DrawingUnit(UNITS_M[best], f'units are {best}, as the file states')
    statement = f'states {stated}' if stated else 'states no unit'
    note = f'the file {statement}, but {doors} door widths imply {best}'
    return DrawingUnit(UNITS_M[best], f'units are {best}, from {doors} door widths', (note,))


def _support(unit_m: float, evidence: list[tuple[float, tuple[float, float, float]]]) -> float:
    """Return the log-likelihood of a unit given lengths [units] and their typical values."""
    support = 0.0
    for length, (typical_m, spread, worst) in evidence:
        if length > 0.0:
            off = math.log(length * unit_m / typical_m) / spread
            support -= min(0.5 * off**2, worst)
    return support


def wall_thickness(walls: OutlinePieces) -> float | None:
    """
    Return the median distance between neighbouring parallel lines, in the drawing's units.

    None if walls are not drawn as double lines. Only the longest lines are compared.
    """
    order = np.argsort(walls.length)[::-1][:_LONGEST]
    ends, length = walls.ends[order], walls.length[order]
    if len(order) < 4:
        return None
    direction = (ends[:, 1] - ends[:, 0]) / length[:, None]
    gaps = np.array([_gap(k, ends, direction, length) for k in range(len(order))])
    paired = np.isfinite(gaps)
    if length[paired].sum() < _MIN_PAIRED * length.sum():
        return None
    by_gap = np.argsort(gaps[paired])
    share = np.cumsum(length[paired][by_gap])
    return float(gaps[paired][by_gap][np.searchsorted(share, 0.5 * share[-1])])


def _gap(k: int, ends: Array, direction: Array, length: Array) -> float:
    """Return the distance from line ``k`` to the nearest parallel one beside it; inf without."""
    x, y = direction[k]
    parallel = np.abs(direction @ np.array([-y, x])) < math.sin(_PARALLEL)
    away = (ends - ends[k, 0]) @ np.array([[x, -y], [y, x]])  # along, across
    low, high = away[..., 0].min(axis=1), away[..., 0].max(axis=1)
    overlap = np.minimum(high, length[k]) - np.maximum(low, 0.0)
    across = np.abs(away[..., 1].mean(axis=1))
    beside = parallel & (overlap > 0.5 * np.minimum(length, length[k]))
    beside &= (across > 1e-3 * length[k]) & (across < 0.5 * length[k])
    return float(across[beside].min()) if beside.any() else float('inf')
