# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Furniture symbols in rooms of a varied sheet."""

from __future__ import annotations

import numpy as np

from fpnet_lab.sim.sheets.artwork import Array, Mark
from fpnet_lab.sim.sheets.room_frame import Brush, RoomFrame

# All sizes are chosen, not measured.


def desks(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return desks along one long wall, with or without chairs."""
    du, dv = b.uniform(1.2, 2.0), b.uniform(0.6, 0.9)
    rim = float(b.rng.choice([0.0, 0.1, 0.5]))
    u = np.arange(rim, f.length - du - 0.3, du + b.uniform(0.0, 0.8))
    v = np.full(len(u), 0.0 if b.rng.random() < 0.5 else f.width - dv)
    marks = b.boxes(f.boxes(u, v, du, dv))
    if b.rng.random() < 0.6:
        into = dv + 0.3 if len(v) and v[0] == 0.0 else -0.3
        marks += b.rounds(f.at(np.stack([u + du / 2.0, v + into], axis=1)), 0.22)
    return marks


def wall_to_wall(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return a counter or shelf that extends from wall to wall."""
    depth = b.uniform(0.3, 0.8)
    if b.rng.random() < 0.5:
        at = b.uniform(0.0, 1.0) * (f.length - depth)
        return b.boxes([f.box(at, 0.0, depth, f.width)])
    return b.boxes([f.box(0.0, 0.0, f.length, min(depth, 0.4 * f.width))])


def cubicles(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return desks with half-height partitions: thin lines that are not walls."""
    du, dv = b.uniform(1.6, 2.4), b.uniform(1.6, 2.2)
    u, v = f.grid(du, dv, 0.8, 0.8)
    if not len(u):
        return []
    # Three sides of each cell; the fourth is open to an aisle.
    ring = np.array([(0.0, 0.0), (0.0, dv), (du, dv), (du, 0.0)])
    lines = list(f.at(np.stack([u, v], axis=1)[:, None] + ring))
    marks = b.lines(lines)
    return marks + b.boxes(f.boxes(u + 0.1, v + dv - 0.75, du - 0.2, 0.65))


def seats(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return rows of seats, like in a lecture hall."""
    du, dv = b.uniform(0.5, 0.7), b.uniform(0.85, 1.3)
    u, v = f.grid(du, dv, b.uniform(0.6, 1.6), 0.5)
    if b.rng.random() < 0.5:
        return b.boxes(f.boxes(u + 0.05, v, du - 0.1, 0.5))
    return b.rounds(f.at(np.stack([u + du / 2.0, v + 0.25], axis=1)), 0.2)


def racks(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return long parallel shelves with bays, optionally with diagonals."""
    depth, aisle = b.uniform(0.4, 1.1), b.uniform(0.9, 2.5)
    v = np.arange(b.uniform(0.0, 0.8), f.width - depth, depth + aisle)
    rim = b.uniform(0.3, 1.2)
    long = f.length - 2.0 * rim
    marks = b.boxes(f.boxes(np.full(len(v), rim), v, long, depth))
    bays = np.linspace(rim, rim + long, max(2, int(long / b.uniform(1.0, 2.5)) + 1))
    marks += b.lines([f.line((u, w), (u, w + depth)) for w in v for u in bays[1:-1]])
    if b.rng.random() < 0.4:
        marks += b.lines([f.line((rim, w), (rim + long, w + depth)) for w in v])
    return marks


def beds(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return one bed or a row of them, with pillows."""
    wide = b.uniform(0.9, 1.8)
    count = 1 if b.rng.random() < 0.6 else max(1, int((f.length - 0.5) / (wide + 1.0)))
    places = b.uniform(0.1, 0.6) + (wide + 1.0) * np.arange(count)
    u: Array = places[places + wide < f.length].astype(np.float64)
    zero = np.zeros(len(u))
    marks = b.boxes(f.boxes(u, zero, wide, 2.0))
    marks += b.boxes(f.boxes(u + 0.1, zero + 0.08, wide - 0.2, 0.35))
    return marks + b.lines([f.line((x, 0.6), (x + wide, 0.75)) for x in u])


def bath(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return toilets and basins along opposite walls, sometimes a tub."""
    pitch = b.uniform(0.8, 1.1)
    u = np.arange(0.3, f.length - 0.6, pitch)[: int(b.rng.integers(1, 7))]
    marks = b.boxes(f.boxes(u, np.zeros(len(u)), 0.4, 0.18))
    marks += b.rounds(f.at(np.stack([u + 0.2, np.full(len(u), 0.42)], axis=1)), 0.22)
    basins = np.stack([u + 0.2, np.full(len(u), f.width - 0.25)], axis=1)
    marks += b.rounds(f.at(basins), 0.19)
    if len(u) > 1 and b.rng.random() < 0.4:  # screens between the toilets
        marks += b.lines([f.line((x - 0.2, 0.0), (x - 0.2, min(1.3, 0.5 * f.width))) for x in u])
    elif b.rng.random() < 0.5 and f.length > 2.6:
        tub = f.box(f.length - 0.8, 0.0, 0.8, min(1.7, f.width))
        marks += b.boxes([tub, 0.85 * (tub - tub.mean(axis=0)) + tub.mean(axis=0)])
    return marks


def kitchen(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return a straight or L-shaped counter with hob and sink."""
    depth = 0.6
    run = f.length * b.uniform(0.5, 1.0)
    marks = b.boxes([f.box(0.0, 0.0, run, depth)])
    if b.rng.random() < 0.5:
        marks += b.boxes([f.box(0.0, depth, depth, 0.6 * (f.width - depth))])
    hob = np.array([(0.2, 0.15), (0.45, 0.15), (0.2, 0.42), (0.45, 0.42)])
    marks += b.rounds(f.at(np.add(hob, (0.4 * run, 0.0))), 0.09)
    return marks + b.boxes([f.box(0.7 * run, 0.12, 0.5, 0.36)])


def cars(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return parked cars in top view, with windscreens."""
    wide, long = 1.8, b.uniform(4.0, 4.8)
    if f.width < long + 0.3:
        return []
    marks: list[Mark] = []
    for u in np.arange(0.4, f.length - wide - 0.3, b.uniform(2.4, 2.8)):
        body = np.array(
            [
                *((0.25, 0.0), (1.55, 0.0), (1.8, 0.5), (1.8, long - 0.5), (1.5, long)),
                *((0.3, long), (0.0, long - 0.5), (0.0, 0.5)),
            ]
        )
        marks += b.boxes([f.at(np.add(body, (u, 0.2)))])
        panes = [(0.3, 1.2, 1.2, 0.5), (0.3, long - 1.2, 1.2, 0.4)]
        marks += b.lines([f.box(u + x, 0.2 + y, w, h)[[0, 1, 2, 3, 0]] for x, y, w, h in panes])
    return marks


def pots(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return potted plants along the walls: circles with a star."""
    radius = b.uniform(0.2, 0.6)
    count = int(b.rng.integers(1, 5))
    rim = radius + 0.1
    places = np.stack(
        [
            b.rng.uniform(rim, max(f.length - rim, rim + 0.01), count),
            b.rng.choice([rim, max(f.width - rim, rim)], count),
        ],
        axis=1,
    )
    centre = f.at(places)
    spikes = [c + 0.9 * radius * np.stack([d, -d]) for c in centre for d in _STAR]
    return b.rounds(centre, radius) + b.lines(spikes)


_STAR: list[Array] = [
    np.array([np.cos(a), np.sin(a)]) for a in np.arange(0.0, np.pi, np.pi / 4.0).tolist()
]


def machines(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return machines as boxes, some with a diagonal or a cross."""
    marks: list[Mark] = []
    for _ in range(int(b.rng.integers(1, 7))):
        du, dv = b.uniform(0.5, 0.4 * f.length), b.uniform(0.4, 0.4 * f.width)
        u, v = b.uniform(0.0, f.length - du), b.uniform(0.0, f.width - dv)
        ring = f.box(u, v, du, dv)
        marks += b.boxes([ring])
        marks += b.lines([ring[[0, 2]], ring[[1, 3]]][: int(b.rng.integers(0, 3))])
    return marks


def table(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return one long table in the middle of the room with chairs on both sides."""
    du, dv = f.length * b.uniform(0.3, 0.65), f.width * b.uniform(0.2, 0.4)
    u, v = (f.length - du) / 2.0, (f.width - dv) / 2.0
    marks = b.boxes([f.box(u, v, du, dv)])
    chairs = np.arange(u + 0.1, u + du - 0.4, b.uniform(0.6, 0.9))
    low, high = np.full(len(chairs), v - 0.5), np.full(len(chairs), v + dv + 0.05)
    return marks + b.boxes(f.boxes(chairs, low, 0.42, 0.42) + f.boxes(chairs, high, 0.42, 0.42))
