# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Stairs, lifts, ramps, voids and overhead symbols in rooms of a varied sheet."""

from __future__ import annotations

import numpy as np

from fpnet_lab.sim.sheets.artwork import Array, Letters, Mark, Role
from fpnet_lab.sim.sheets.hatching import hatched
from fpnet_lab.sim.sheets.room_frame import Brush, RoomFrame
from fpnet_lab.sim.sheets.storeys import arrow_head

# All sizes are chosen, not measured.

_TREAD_M = (0.25, 0.32)  # depth of a tread; chosen
_UP = ('UP', 'DN', 'auf', 'up', '17 Stg.', '18 x 16.7/29')


def _treads(f: RoomFrame, u: Array, v0: float, v1: float) -> list[Array]:
    ends = np.stack([np.full((len(u), 2), v0), np.full((len(u), 2), v1)], axis=1)
    ends[..., 0] = u[:, None]
    return list(f.at(ends))


def _walk(b: Brush, line: Array, has_text: bool) -> list[Mark]:
    """Return the walking line with an arrowhead, and optionally a text."""
    head = arrow_head(line[-2], line[-1], b.look.mm(2.0))
    marks = b.lines([line, *head], Role.STAIRS)
    if has_text:
        height = 0.7 * b.look.letter_m
        text = _UP[int(b.rng.integers(len(_UP)))]
        x, y = line[0].tolist()
        marks.append(Letters(Role.TEXT, text, (x, y), height, b.look.letters, b.look.font))
    return marks


def straight_stairs(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return one flight of stairs with an arrow and optionally a cut line."""
    wide = f.width if f.width < 2.5 else b.uniform(1.2, 2.4)
    start = b.uniform(0.1, 0.25) * f.length
    treads = np.arange(start, f.length - 0.8, b.uniform(*_TREAD_M))[:20]
    if len(treads) < 3:
        return []
    marks: list[Mark] = b.boxes([f.box(treads[0], 0.0, treads[-1] - treads[0], wide)], Role.STAIRS)
    marks += b.lines(_treads(f, treads, 0.0, wide), Role.STAIRS)
    middle = wide / 2.0
    marks += _walk(b, f.line((treads[0], middle), (treads[-1], middle)), b.rng.random() < 0.5)
    if b.rng.random() < 0.5:
        cut = treads[len(treads) // 2]
        zigzag = [(cut - 0.3, 0.0), (cut, 0.45 * wide), (cut + 0.1, 0.35 * wide)]
        zigzag += [(cut + 0.05, 0.6 * wide), (cut + 0.4, wide)]
        marks += b.lines([f.line(*zigzag)], Role.STAIRS)
    return marks


def turning_stairs(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return two parallel flights of stairs connected by a landing."""
    length, wide = min(f.length, b.uniform(3.5, 6.5)), min(f.width, 3.6)
    landing = min(wide / 2.0, 0.35 * length)
    treads = np.arange(0.3, length - landing, b.uniform(*_TREAD_M))
    if len(treads) < 3:
        return []
    gap = b.uniform(0.0, 0.15)
    half = wide / 2.0
    marks: list[Mark] = b.boxes([f.box(0.0, 0.0, length, wide)], Role.STAIRS)
    marks += b.lines(_treads(f, treads, 0.0, half - gap), Role.STAIRS)
    marks += b.lines(_treads(f, treads, half + gap, wide), Role.STAIRS)
    well = f.box(treads[0], half - gap, treads[-1] - treads[0], 2.0 * gap)
    marks += b.lines([well[[0, 1, 2, 3, 0]]], Role.STAIRS)
    turn = length - landing / 2.0
    low, high = half / 2.0, 1.5 * half
    walk = f.line((treads[0], low), (turn, low), (turn, high), (treads[0], high))
    return marks + _walk(b, walk, b.rng.random() < 0.4)


def spiral_stairs(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return spiral steps around a post."""
    radius = min(0.45 * f.width, b.uniform(0.8, 1.4))
    centre = f.line((f.length * b.uniform(0.3, 0.7), f.width / 2.0))[0]
    turn = b.uniform(1.4, 2.0) * np.pi
    angle = np.linspace(0.0, turn, int(b.rng.integers(10, 18)))
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    steps = centre + np.stack([0.12 * unit, radius * unit], axis=1)
    marks = b.lines(list(steps), Role.STAIRS)
    marks.append(b.arc(centre, radius, 0.0, turn))
    path = centre + 0.65 * radius * unit
    return [*marks, *b.rounds(centre[None], 0.12, Role.STAIRS), *_walk(b, path[1:-1], False)]


def ramp(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return a ramp with its outline, two lines that meet at its top, and its slope."""
    length, wide = f.length * b.uniform(0.5, 0.9), min(f.width, b.uniform(1.2, 3.5))
    ring = f.box(0.05 * f.length, 0.0, length, wide)
    marks: list[Mark] = b.boxes([ring], Role.STAIRS)
    top = (ring[1] + ring[2]) / 2.0
    marks += b.lines([np.stack([ring[0], top, ring[3]])], Role.STAIRS)
    x, y = ring.mean(axis=0).tolist()
    text = f'{int(b.rng.integers(4, 13))} %'
    look = b.look
    height = 0.7 * look.letter_m
    letters = Letters(Role.TEXT, text, (x, y), height, look.letters, look.font, f.angle_rad)
    return [*marks, letters]


def escalator(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return one or two narrow escalators with fine steps between rails."""
    length = min(0.8 * f.length, b.uniform(6.0, 12.0))
    start = (f.length - length) / 2.0
    marks: list[Mark] = []
    for lane in range(int(b.rng.integers(1, 3))):
        v = 0.3 + 1.5 * lane
        if v + 1.2 > f.width:
            break
        marks += b.boxes([f.box(start, v, length, 1.2)], Role.STAIRS)
        rails = [f.line((start, w), (start + length, w)) for w in (v + 0.12, v + 1.08)]
        steps = _treads(f, np.arange(start, start + length, 0.4), v + 0.12, v + 1.08)
        marks += b.lines(rails + steps, Role.STAIRS)
    return marks


def lift(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return a lift car with a cross and a counterweight."""
    du, dv = min(f.length - 0.1, b.uniform(1.2, 2.4)), min(f.width - 0.1, b.uniform(1.2, 2.2))
    ring = f.box(0.05, 0.05, du, dv)
    marks = b.boxes([ring], Role.STAIRS) + b.lines([ring[[0, 2]], ring[[1, 3]]], Role.STAIRS)
    return marks + b.boxes([f.box(0.05 + 0.3 * du, 0.08, 0.4 * du, 0.15)], Role.STAIRS)


def void(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return an opening in the floor: a dashed outline with diagonals."""
    rim = b.uniform(0.0, 0.2)
    ring = f.box(
        rim * f.length, rim * f.width, (1.0 - 2.0 * rim) * f.length, (1.0 - 2.0 * rim) * f.width
    )
    return b.dashed([ring[[0, 2]], ring[[1, 3]], ring[[0, 1, 2, 3, 0]]])


def ceiling(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return a dashed grid of ceiling panels."""
    pitch = max(b.uniform(0.6, 1.2), 10.0 * b.look.resolution_m)
    us, vs = np.arange(pitch / 2.0, f.length, pitch), np.arange(pitch / 2.0, f.width, pitch)
    lines = [f.line((u, 0.0), (u, f.width)) for u in us]
    return b.dashed(lines + [f.line((0.0, v), (f.length, v)) for v in vs], Role.FILL)


def beams(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return beams as pairs of dashed lines from wall to wall."""
    lines: list[Array] = []
    for u in np.arange(b.uniform(0.5, 2.0), f.length - 0.4, b.uniform(1.5, 5.0)):
        lines += [f.line((u, 0.0), (u, f.width)), f.line((u + 0.3, 0.0), (u + 0.3, f.width))]
    return b.dashed(lines, Role.FILL)


def sprinklers(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return sprinklers as small circles or dots on a grid, optionally with pipes."""
    pitch = b.uniform(1.2, 3.5)
    u, v = f.grid(pitch, pitch, 0.1, 0.1)
    if not len(u):
        return []
    centre = f.at(np.stack([u, v], axis=1) + pitch / 2.0)
    marks = b.rounds(centre, max(b.uniform(0.05, 0.15), 1.5 * b.look.resolution_m))
    if b.rng.random() < 0.4:
        rows = np.unique(v) + pitch / 2.0
        marks += b.lines([f.line((0.0, w), (f.length, w)) for w in rows])
    return marks


def shaft(f: RoomFrame, b: Brush) -> list[Mark]:
    """Return a small room filled with hatching."""
    ring = f.box(0.0, 0.0, f.length, f.width)
    spacing = max(b.look.mm(b.uniform(0.8, 2.5)), 5.0 * b.look.resolution_m)
    return b.lines(list(hatched([ring], f.angle_rad + np.pi / 4.0, spacing)), Role.FILL)
