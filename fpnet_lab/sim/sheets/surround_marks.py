# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Marks around and over a building on varied sheets: dimensions, eaves, frames, axes, notes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fpnet_lab.sim.sheets.grounds import (
    Grounds,
    boundary,
    contours,
    court,
    hedge,
    lawn,
    neighbours,
    parking,
    pool,
    road,
    terrace,
    trees,
)
from fpnet_lab.sim.sheets.sketch import Array, Rgb

# All sizes, counts and colours here are chosen, not measured.


def eaves(site: Grounds) -> None:
    """Draw the dashed edge of the roof around the building."""
    s = site.s
    colour = s.pen()
    for ring in site.ring(site.per_m * s.pick(0.3, 1.5)):
        s.dashed(ring, colour, s.pick(1, 2), s.unit * s.pick(4, 10))


def near_frame(site: Grounds) -> None:
    """Draw a heavy or double frame close around the building."""
    s = site.s
    left, top, right, bottom = site.bounds
    far = s.pick(0.01, 0.04) * max(right - left, bottom - top) + 2
    rect = (int(left - far), int(top - far), int(right + far), int(bottom + far))
    pens, colour = s.pick(1, 8), s.pen()
    s.box(rect, None, colour, pens)
    if s.chance(0.4):
        more = int(s.unit * (3 + pens))
        a, b, c, d = rect
        s.box((a - more, b - more, c + more, d + more), None, colour, s.pick(1, 4))


def dimensions(site: Grounds) -> None:
    """Draw dimension chains on one to four sides, in one to three rows."""
    s = site.s
    left, top, right, bottom = site.bounds
    ends, colour = int(s.rng.integers(4)), s.pen()
    pitch, start = s.unit * s.pick(12, 26), s.unit * s.pick(6, 30)
    unit = int(s.rng.integers(4))
    for side in s.rng.permutation(4)[: int(s.rng.integers(1, 5))].tolist():
        low, high = (left, right) if side < 2 else (top, bottom)
        for row in range(int(s.rng.integers(1, 4))):
            count = int(s.rng.integers(0, 9)) if row < 2 else 0
            cuts = np.sort(np.r_[low, high, s.rng.uniform(low, high, count)])
            far = start + row * pitch
            at = (top - far, bottom + far, left - far, right + far)[side]
            foot = 0.4 * pitch * (1 if side % 2 == 0 else -1)
            for a, b in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
                text = _length((b - a) / site.per_m, unit)
                _chain(site, (a, b, at, foot), side < 2, ends, text, colour)


def _length(metres: float, unit: int) -> str:
    if unit == 0:
        return f'{metres:.2f}'
    if unit == 1:
        return f'{1e3 * metres:.0f}'
    inches = round(metres / 0.0254)
    return f'{inches // 12}\'-{inches % 12}"' if unit == 2 else f'{metres:.2f} m'


def _chain(
    site: Grounds,
    spans: tuple[float, float, float, float],
    is_level: bool,
    ends: int,
    text: str,
    colour: Rgb,
) -> None:
    """Draw one dimension: its line, extension lines, text and end marks, if any."""
    s = site.s
    a, b, at, foot = spans

    def put(points: list[tuple[float, float]]) -> Array:
        found = np.array(points)
        return found if is_level else found[:, ::-1]

    s.line(put([(a, at), (b, at)]), colour)
    tick = 3.5 * s.unit
    for x, inwards in ((a, 1), (b, -1)):
        s.line(put([(x, at - foot), (x, at + foot)]), colour, 0.7)
        if ends == 0:
            s.line(put([(x - tick, at + tick), (x + tick, at - tick)]), colour, 1.5)
        elif ends == 1:
            tip = put(
                [
                    (x, at),
                    (x + 2 * inwards * tick, at + tick),
                    (x + 2 * inwards * tick, at - tick),
                ]
            )
            s.fill(tip, colour)
        elif ends == 2:
            spot = put([(x, at)])[0]
            s.disc(float(spot[0]), float(spot[1]), 0.6 * tick, colour, None)
    height = 6 * s.unit
    if b - a > 3.5 * height:
        x, y = put([((a + b) / 2, at - height)])[0].tolist()
        s.text(text, x, y, height, colour, is_centred=True, is_upright=not is_level)


Maker = Callable[[Grounds], None]

AROUND_MAKERS: dict[str, Maker] = {
    'lawn': lawn,
    'contours': contours,
    'road': road,
    'parking': parking,
    'neighbours': neighbours,
    'pool': pool,
    'terrace': terrace,
    'court': court,
    'boundary': boundary,
    'hedge': hedge,
    'trees': trees,
    'eaves': eaves,
    'near frame': near_frame,
    'dimensions': dimensions,
}
"""Components around a building, the lowest first."""


def axes(site: Grounds) -> None:
    """Draw axes across the building, with bubbles on random sides."""
    s = site.s
    left, top, right, bottom = site.bounds
    far, radius = s.unit * s.pick(12, 50), s.unit * s.pick(6, 12)
    colour = s.colour(80, 220) if s.chance(0.4) else s.pen()
    is_dashed, sides = s.chance(0.7), s.rng.random(4) < 0.6
    for axis, (low, high, start, end) in enumerate(
        ((left, right, top, bottom), (top, bottom, left, right))
    ):
        cuts = np.linspace(low, high, int(s.rng.integers(2, 9)))
        cuts[1:-1] += s.rng.uniform(-0.3, 0.3, len(cuts) - 2) * (high - low) / len(cuts)
        for i, at in enumerate(cuts.tolist()):
            line = np.array([(at, start - far), (at, end + far)])
            line = line if axis == 0 else line[:, ::-1].copy()
            if is_dashed:
                s.dashed(line, colour, 0.8, 9 * s.unit)
            else:
                s.line(line, colour, 0.8)
            for k in (0, 1):
                if sides[2 * axis + k]:
                    x, y = (line[k] + (2 * k - 1) * np.eye(2)[1 - axis] * radius).tolist()
                    s.disc(x, y, radius, s.ink)
                    s.text(chr(65 + i) if axis else str(i + 1), x, y, radius, is_centred=True)


def section(site: Grounds) -> None:
    """Draw section lines across the building, with arrows and letters."""
    s = site.s
    left, top, right, bottom = site.bounds
    far, size, colour = s.unit * s.pick(10, 60), s.unit * s.pick(5, 12), s.pen()
    for letter in 'AB'[: int(s.rng.integers(1, 3))]:
        if s.chance(0.5):
            x = s.pick(left, right)
            line, side = np.array([(x, top - far), (x, bottom + far)]), np.array([1.0, 0.0])
        else:
            y = s.pick(top, bottom)
            line, side = np.array([(left - far, y), (right + far, y)]), np.array([0.0, 1.0])
        if s.chance(0.7):
            s.dashed(line, colour, s.pick(1, 2.5), 12 * s.unit)
        else:
            s.line(line, colour)
        for end in line:
            across = side[::-1] * size
            s.fill(np.stack([end - across, end + across, end + 1.8 * size * side]), colour)
            x, y = (end - 1.5 * size * side).tolist()
            s.text(letter, x, y, 1.2 * size, colour, is_centred=True)


def leaders(site: Grounds) -> None:
    """Draw notes beside the building, with leader lines into it."""
    s = site.s
    left, top, right, bottom = site.bounds
    colour = s.pen()
    for _ in range(int(s.rng.integers(1, 9))):
        is_right = s.chance(0.5)
        tip = np.array([s.pick(left, right), s.pick(top, bottom)])
        x = right + site.gap if is_right else left - site.gap
        y = s.pick(top, bottom)
        s.line(np.stack([tip, (x, y)]), colour)
        s.disc(tip[0], tip[1], 2 * s.unit, colour, None)
        height = s.unit * s.pick(5, 9)
        text = s.words(int(s.rng.integers(1, 4)))
        start = x + 3 if is_right else x - 0.8 * height * len(text) - 3
        s.text(text, start, y - height / 2, height, colour)


OVER_MAKERS: dict[str, Maker] = {'axes': axes, 'section': section, 'leaders': leaders}
"""Components drawn over a building."""
