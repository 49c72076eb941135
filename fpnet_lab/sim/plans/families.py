# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Layout families of corridors and banks of rooms; each returns the cells of a storey."""

from __future__ import annotations

from collections.abc import Callable
import math

import numpy as np
from shapely import Polygon

from fpnet_lab.sim.plans.layout import Cell, Style
from fpnet_lab.sim.plans.skeleton import Arm, build_cells

CORRIDOR_WIDTHS_M = (1.6, 3.0)
BANK_DEPTHS_M = (2.6, 8.5)
BANK_SPREAD = 0.25
"""
Standard deviation of the logarithm of a bank's depth relative to the side of a typical room.
Fitted by hand to the development split (docs/simulator.md).
"""


def corridor_width(rng: np.random.Generator) -> float:
    """Sample the width of a corridor [m]."""
    return float(rng.uniform(*CORRIDOR_WIDTHS_M))


def bank_depth(rng: np.random.Generator, style: Style) -> float:
    """Sample the depth of a bank of rooms [m]: a typical room is about square."""
    depth = style.room_side_m * math.exp(BANK_SPREAD * rng.standard_normal())
    return float(np.clip(depth, *BANK_DEPTHS_M))


def double_corridor(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out one straight corridor with rooms on both sides, rarely on one."""
    length, left, right = rng.uniform(28.0, 80.0), bank_depth(rng, style), bank_depth(rng, style)
    right *= rng.random() < 0.9
    foot, cap = (bank_depth(rng, style) * float(rng.random() < 0.4) for _ in range(2))
    arm = Arm((0.0, 0.0), (length, 0.0), corridor_width(rng), left, right, foot_m=foot, cap_m=cap)
    return build_cells(rng, [arm], style)


def racetrack(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out a loop of corridors around a core of rooms or a courtyard."""
    width, outer = corridor_width(rng), bank_depth(rng, style)
    x, y = float(rng.uniform(22.0, 55.0)), float(rng.uniform(13.0, 30.0))
    inner = min(bank_depth(rng, style), (y - width) / 2.0)
    has_bank = [True, bool(rng.random() < 0.8), True, bool(rng.random() < 0.8)]
    corners = [(0.0, 0.0), (x, 0.0), (x, y), (0.0, y)]
    arms = []
    for i in range(4):
        beyond = [width / 2.0 + outer * has_bank[j] for j in (i - 1, (i + 1) % 4)]
        arms.append(
            Arm(
                corners[i],
                corners[(i + 1) % 4],
                width,
                inner,
                outer * has_bank[i],
                before_m=beyond[0],
                after_m=beyond[1],
            )
        )
    return build_cells(rng, arms, style)


def branched(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out a spine with one to four perpendicular wings: L, T, comb or H shapes."""
    return _spine_with_wings(rng, style, lambda: np.pi / 2.0)


def diagonal(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out a spine with wings that branch off at 35 to 75 degrees."""
    angle = float(np.deg2rad(rng.uniform(35.0, 75.0)))
    return _spine_with_wings(rng, style, lambda: angle if rng.random() < 0.5 else np.pi - angle)


def _spine_with_wings(
    rng: np.random.Generator, style: Style, angle: Callable[[], float]
) -> list[Cell]:
    width, depth = corridor_width(rng), bank_depth(rng, style)
    wings = int(rng.integers(1, 5))
    pitch = 2.0 * depth + width + rng.uniform(2.0, 14.0)
    length = max(18.0, wings * pitch * rng.uniform(0.75, 1.0))
    arms = [Arm((0.0, 0.0), (length, 0.0), width, depth, depth, cap_m=depth * (wings < 2))]
    slots = np.linspace(width / 2.0, length - width / 2.0, max(wings, 2))
    for wing in range(wings):
        x = float(slots[wing])
        side = 1.0 if rng.random() < 0.75 else -1.0
        heading, reach = float(angle()), rng.uniform(14.0, 30.0)
        end = (x + reach * math.cos(heading), side * reach * math.sin(heading))
        cap = depth if rng.random() < 0.5 else 0.0
        arms.append(
            Arm((x, 0.0), end, width, depth, depth, before_m=width / 2.0 + depth, cap_m=cap)
        )
    return build_cells(rng, arms, style)


def central_hall(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out rooms around a hall, with corridors leading away from it."""
    width, depth = corridor_width(rng), bank_depth(rng, style)
    hall = np.array([rng.uniform(9.0, 22.0), rng.uniform(7.0, 13.0)])
    arms = [Arm((-hall[0] / 2.0, 0.0), (hall[0] / 2.0, 0.0), hall[1], depth, depth, kind='hall')]
    for sign in (1.0, -1.0):
        if rng.random() < 0.85:
            reach, y = rng.uniform(10.0, 26.0), rng.uniform(-0.3, 0.3) * hall[1]
            cap = depth if rng.random() < 0.5 else 0.0
            arms.append(
                Arm(
                    (sign * hall[0] / 2.0, y),
                    (sign * (hall[0] / 2.0 + reach), y),
                    width,
                    depth,
                    depth,
                    cap_m=cap,
                )
            )
        if rng.random() < 0.45:
            reach, x = hall[1] / 2.0 + rng.uniform(10.0, 20.0), rng.uniform(-0.3, 0.3) * hall[0]
            arms.append(Arm((x, 0.0), (x, sign * reach), width, depth, depth, cap_m=depth))
    return build_cells(rng, arms, style)


def ring_polygon(rng: np.random.Generator, style: Style) -> list[Cell]:
    """Lay out a corridor loop along a regular polygon of five, six or eight sides."""
    sides, width, depth = (
        int(rng.choice([5, 5, 6, 8])),
        corridor_width(rng),
        bank_depth(rng, style),
    )
    radius = rng.uniform(14.0, 26.0)
    angles = rng.uniform(0.0, np.pi) + np.arange(sides) * 2.0 * np.pi / sides
    corners = [(float(radius * math.cos(a)), float(radius * math.sin(a))) for a in angles]
    apothem = radius * math.cos(np.pi / sides) - width / 2.0
    inner = min(bank_depth(rng, style), 0.6 * apothem)
    beyond = float((width / 2.0 + depth) * math.tan(np.pi / sides))
    arms = []
    for i in range(sides):
        start, end = corners[i], corners[(i + 1) % sides]
        sector = Polygon([(0.0, 0.0), *(3.0 * np.array([start, end])).tolist()])
        arms.append(
            Arm(start, end, width, inner, depth, 'corridor', beyond, beyond, bounds=sector)
        )
    return build_cells(rng, arms, style)
