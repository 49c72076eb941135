# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pictures without a floorplan, for which all pixels are outside: :func:`draw_negative`."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from fpnet_lab.sim.sheets.blocks import (
    BLOCK_MAKERS,
    draw_block,
    elevation,
    hatched,
    key_plan,
    logo,
    paragraph,
    scene,
    table,
)
from fpnet_lab.sim.sheets.picture_effects import marked, taken
from fpnet_lab.sim.sheets.sketch import Array, Pixels, Rect, Sketch, blank
from fpnet_lab.sim.sheets.surround_style import SurroundStyle, draw_surround_style

# All sizes, counts and colours here are chosen, not measured.

_SIDES_PX = (350.0, 1500.0)  # of a picture's longer side; chosen
_OFFSET = 7919  # numerical: seed offset that separates negatives from sheets
_EFFECT_SHARE = 0.6  # share of negatives with picture effects; chosen


def draw_negative(seed: int) -> Pixels:
    """Return a picture (H, W, 3) without a floorplan; equal seeds give equal pictures."""
    rng = np.random.default_rng([seed, _OFFSET])
    low, high = np.log(_SIDES_PX)
    side = float(np.exp(rng.uniform(low, high)))
    other = side * float(rng.uniform(0.5, 1.0))
    shape = (int(side), int(other)) if rng.random() < 0.5 else (int(other), int(side))
    names = list(NEGATIVES)
    name = names[int(rng.integers(len(names)))]
    pixels = negative(name, shape, rng)
    style = draw_surround_style(rng)
    if rng.random() < _EFFECT_SHARE:
        pixels = marked(pixels, style, wobble_px=2.0)
        pixels, _ = taken(pixels, _kept_large(style))
    return np.ascontiguousarray(pixels)


def _kept_large(style: SurroundStyle) -> SurroundStyle:
    return SurroundStyle(style.parts, style.effects - {'shrink'}, style.framing, style.seed)


def negative(name: str, shape: tuple[int, int], rng: np.random.Generator) -> Pixels:
    """Return a picture (H, W, 3) of a kind ``name`` of :data:`NEGATIVES`."""
    if name == 'photo':
        return np.asarray(scene(rng, shape), np.uint8)
    is_dark = rng.random() < 0.12
    r, g, b = (rng.integers(0, 50, 3) if is_dark else rng.integers(225, 256, 3)).tolist()
    paper = (255, 255, 255) if rng.random() < 0.6 and not is_dark else (r, g, b)
    tone = int(rng.integers(190, 256)) if is_dark else int(rng.integers(0, 90))
    unit = float(np.clip(max(shape) / 1000.0 * rng.uniform(0.7, 2.0), 0.7, 4.0))
    s = Sketch(blank(shape, paper), rng, (tone,) * 3, paper, unit)
    NEGATIVES[name](s)
    if s.chance(0.3):
        s.taken = None
        for block in s.rng.choice(list(BLOCK_MAKERS), 3).tolist():
            draw_block(s, block)
    return s.pixels


def _grid(s: Sketch, columns: int, rows: int, share: float = 0.7) -> list[Rect]:
    """Return rectangles on a grid that cover ``share`` of their cells in each direction."""
    width, height = s.size
    xs, ys = np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1)
    dx, dy = (1 - share) * width / columns / 2, (1 - share) * height / rows / 2
    return [
        (int(xs[c] + dx), int(ys[r] + dy), int(xs[c + 1] - dx), int(ys[r + 1] - dy))
        for r in range(rows)
        for c in range(columns)
    ]


def _elbow(a: Array, b: Array, is_first_level: bool) -> Array:
    middle = (b[0], a[1]) if is_first_level else (a[0], b[1])
    return np.array([a, middle, b])


def _circuit(s: Sketch) -> None:
    """Draw a circuit of rectangular wires with resistors, gates and dots."""
    columns, rows = int(s.rng.integers(3, 9)), int(s.rng.integers(3, 8))
    boxes = _grid(s, columns, rows, s.pick(0.2, 0.5))
    middles = np.array([((a + c) / 2, (b + d) / 2) for a, b, c, d in boxes])
    pen, pens = s.pen(), s.pick(1, 3)
    for _ in range(2 * len(boxes)):
        i = int(s.rng.integers(len(boxes)))
        j = i + (1 if s.chance(0.6) else columns)
        if j < len(boxes):
            s.line(_elbow(middles[i], middles[j], s.chance(0.5)), pen, pens)
            if s.chance(0.4):
                x, y = middles[j].tolist()
                s.disc(x, y, 2.5 * s.unit, pen, None)
    for box, (x, y) in zip(boxes, middles.tolist(), strict=True):
        a, b, c, d = box
        pick = s.rng.random()
        if pick < 0.25:
            s.box((a, int(y - (d - b) / 5), c, int(y + (d - b) / 5)), s.paper, pen, pens)
        elif pick < 0.45:
            t = np.linspace(0, 1, 9)
            zigzag = np.stack([a + t * (c - a), y + (d - b) / 4 * (np.arange(9) % 2 - 0.5)], 1)
            s.line(zigzag, pen, pens)
        elif pick < 0.6:
            s.disc(x, y, min(c - a, d - b) / 3, pen, pens)
        elif pick < 0.75:
            s.line(np.array([(a, b), (a, d), (c, y)]), pen, pens, is_closed=True)
        elif pick < 0.85:
            s.box(box, s.paper, pen, pens)
        if s.chance(0.6):
            s.text(f'{s.rng.choice(list("RCLUQD"))}{int(s.rng.integers(1, 40))}', a, b, 8 * s.unit)


def _flow_chart(s: Sketch) -> None:
    """Draw boxes and diamonds with texts, connected by arrows."""
    columns, rows = int(s.rng.integers(1, 5)), int(s.rng.integers(2, 8))
    boxes = _grid(s, columns, rows, s.pick(0.4, 0.75))
    pen = s.pen()
    for i, (a, b, c, d) in enumerate(boxes):
        x = (a + c) / 2
        if i + columns < len(boxes) and s.chance(0.8):
            end = boxes[i + columns][1]
            s.line(np.array([(x, d), (x, end)]), pen, 1.5)
            tip = 5 * s.unit
            s.fill(np.array([(x, end), (x - tip, end - tip), (x + tip, end - tip)]), pen)
        if (i + 1) % columns and s.chance(0.3):
            y = (b + d) / 2
            s.line(np.array([(c, y), (boxes[i + 1][0], y)]), pen, 1.5)
        fill = s.pale() if s.chance(0.6) else None
        if s.chance(0.25):
            ring = np.array([(x, b), (c, (b + d) / 2), (x, d), (a, (b + d) / 2)])
            s.fill(ring, fill or s.paper)
            s.line(ring, pen, 1.5, is_closed=True)
        else:
            s.box((a, b, c, d), fill, pen, s.pick(1, 3))
        s.text(s.words(2), x, (b + d) / 2, 9 * s.unit, is_centred=True, most_px=0.8 * (c - a))


def _org_chart(s: Sketch) -> None:
    """Draw a tree of boxes."""
    width, height = s.size
    levels = int(s.rng.integers(2, 5))
    high, pen = height / levels, s.pen()
    fill = s.pale()
    above = [(0.0, float(width))]
    for level in range(levels):
        spans, y = [], (level + 0.2) * high
        for low, up in above:
            x, half = (low + up) / 2, min(0.4 * (up - low), 0.15 * width)
            rect = (int(x - half), int(y), int(x + half), int(y + 0.5 * high))
            s.box(rect, fill, pen, 1.5)
            s.text(s.words(2), x, y + 0.25 * high, 8 * s.unit, is_centred=True, most_px=1.8 * half)
            cuts = np.linspace(low, up, int(s.rng.integers(2, 5)) + 1)
            spans += list(zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True))
            if level + 1 < levels:
                for a, b in pairwise(cuts.tolist()):
                    line = _elbow(
                        np.array([x, y + 0.85 * high]), np.array([(a + b) / 2, y + high]), True
                    )
                    s.line(np.vstack([[(x, y + 0.5 * high)], line]), pen)
        above = spans


def _spreadsheet(s: Sketch) -> None:
    """Draw one to three tables."""
    width, height = s.size
    if s.chance(0.5):
        table(s, (4, 4, width - 5, height - 5))
        return
    for a, b, c, d in _grid(s, 1, int(s.rng.integers(1, 4)), 0.85):
        table(s, (a, b, c, d))


def _chart(s: Sketch) -> None:
    """Draw bar, line or pie charts."""
    for rect in _grid(s, int(s.rng.integers(1, 4)), int(s.rng.integers(1, 3)), 0.75):
        a, b, c, d = rect
        pick, count = s.rng.random(), int(s.rng.integers(3, 14))
        if pick < 0.25:
            at = np.r_[0, np.cumsum(s.rng.uniform(0.2, 1, count))]
            at = at / at[-1] * 2 * np.pi
            radius = min(c - a, d - b) / 2
            for t0, t1 in pairwise(at.tolist()):
                t = np.linspace(t0, t1, 20)
                arc = radius * np.stack([np.cos(t), np.sin(t)], 1)
                ring = np.vstack([[(0, 0)], arc]) + np.array([(a + c) / 2, (b + d) / 2])
                s.fill(ring, s.colour(60, 250))
                s.line(ring, s.paper, 1.5, is_closed=True)
            continue
        for y in np.linspace(b, d, int(s.rng.integers(3, 8))):
            s.line(np.array([(a, y), (c, y)]), s.pale())
            s.text(f'{s.pick(0, 100):.0f}', a - 20 * s.unit, float(y) - 4, 7 * s.unit)
        s.line(np.array([(a, b), (a, d), (c, d)]), s.ink, 2)
        xs, colour = np.linspace(a, c, count + 1), s.colour(30, 220)
        heights = s.rng.uniform(0.1, 0.95, count) * (d - b)
        if pick < 0.65:
            gap = s.pick(0.0, 0.35) * (c - a) / count
            for x0, x1, h in zip(xs[:-1], xs[1:], heights, strict=True):
                bar = (int(x0 + gap), int(d - h), int(x1 - gap), d)
                s.box(bar, colour if s.chance(0.9) else None, s.ink if s.chance(0.3) else None)
        else:
            for _ in range(int(s.rng.integers(1, 4))):
                walk = np.cumsum(s.rng.normal(0, 0.1, count + 1)) + 0.5
                line = np.stack([xs, d - np.clip(walk, 0, 1) * (d - b)], 1)
                s.line(line, s.colour(0, 220), s.pick(1, 3))


def _street_map(s: Sketch) -> None:
    """Draw a street network with water, parks and names."""
    width, height = s.size
    side = max(width, height)
    for _ in range(int(s.rng.integers(0, 4))):
        ring = s.rng.uniform((0, 0), (width, height), 2) + np.cumsum(
            s.rng.normal(0, 0.08 * side, (8, 2)), axis=0
        )
        s.fill(ring, (170, 205, 235) if s.chance(0.4) else (195, 225, 180))
    middle = np.array([width / 2, height / 2])
    angle, colour, edge = s.pick(0, np.pi), s.colour(200, 256), s.pen()
    lines = []
    for k in range(2):
        c, n = np.cos(angle + k * np.pi / 2), np.sin(angle + k * np.pi / 2)
        for far in np.arange(-side, side, side * s.pick(0.06, 0.2)):
            t = np.linspace(-side, side, 12)
            bend = s.rng.normal(0, 0.01 * side, 12) + far
            points = np.stack([c * t - n * bend, n * t + c * bend], 1) + middle
            if s.chance(0.85):
                lines.append((points, s.pick(3, 14)))
    for points, pens in lines:
        s.line(points, edge, pens + 2)
    for points, pens in lines:
        s.line(points, colour, pens)
    if s.chance(0.5):
        for _ in range(60):
            x, y = s.rng.uniform((0, 0), (width, height)).tolist()
            w, h = s.rng.uniform(0.01, 0.03, 2).tolist()
            s.box((int(x), int(y), int(x + w * side), int(y + h * side)), s.pale(), edge)
    for _ in range(12):
        s.text(s.words(2), s.pick(0, width), s.pick(0, height), 8 * s.unit)


def _text_page(s: Sketch) -> None:
    """Write one to three columns of text with headings."""
    width, height = s.size
    s.text(s.words(3).title(), 0.08 * width, 0.03 * height, 0.03 * height)
    for a, _, c, _ in _grid(s, int(s.rng.integers(1, 4)), 1, 0.88):
        y = int(0.1 * height)
        while y < 0.9 * height:
            end = min(y + int(s.pick(0.08, 0.4) * height), int(0.95 * height))
            (draw_picture if s.chance(0.15) else paragraph)(s, (a, y, c, end))
            y = end + int(0.02 * height)


def draw_picture(s: Sketch, rect: Rect) -> None:
    """Paste a photo-like scene if the rectangle is large enough."""
    a, b, c, d = rect
    if c - a > 8 and d - b > 8:
        s.pixels[b:d, a:c] = scene(s.rng, (d - b, c - a))


def _comic(s: Sketch) -> None:
    """Draw panels with scenes and speech bubbles."""
    for a, b, c, d in _grid(s, int(s.rng.integers(1, 5)), int(s.rng.integers(2, 5)), 0.94):
        if s.chance(0.6):
            draw_picture(s, (a, b, c, d))
        else:
            s.box((a, b, c, d), s.pale())
            for _ in range(5):
                x, y = s.pick(a, c), s.pick(b, d)
                s.disc(x, y, s.pick(0.03, 0.2) * (c - a), s.colour(), s.pick(1, 3))
        s.box((a, b, c, d), None, s.ink, s.pick(1, 5))
        if s.chance(0.6):
            x, y, r = s.pick(a, c), b + 0.2 * (d - b), 0.15 * (c - a)
            s.disc(x, y, r, s.paper, None)
            s.disc(x, y, r, s.ink)
            s.text(s.words(1), x, y, 7 * s.unit, is_centred=True, most_px=1.5 * r)


def _facades(s: Sketch) -> None:
    """Draw rows of elevations or sections of buildings."""
    for rect in _grid(s, int(s.rng.integers(1, 3)), int(s.rng.integers(1, 4)), 0.7):
        elevation(s, rect)
        s.text(s.words(3), rect[0], rect[3] + 6, 8 * s.unit)


def _wiring(s: Sketch) -> None:
    """Draw devices connected by coloured lines."""
    boxes = _grid(s, int(s.rng.integers(2, 6)), int(s.rng.integers(2, 5)), s.pick(0.35, 0.6))
    for _ in range(int(s.rng.integers(8, 50))):
        first, second = (boxes[int(s.rng.integers(len(boxes)))] for _ in range(2))
        ends = [np.array([s.pick(r[0], r[2]), s.pick(r[1], r[3])]) for r in (first, second)]
        s.line(_elbow(ends[0], ends[1], s.chance(0.5)), s.colour(0, 230), s.pick(1, 4))
    for rect in boxes:
        s.box(rect, s.pale() if s.chance(0.7) else s.paper, s.ink, s.pick(1, 3))
        s.text(s.words(1), rect[0] + 4, rect[1] + 4, 8 * s.unit)
        for x in np.linspace(rect[0], rect[2], int(s.rng.integers(2, 9)))[1:-1]:
            s.disc(float(x), rect[3] - 4, 2 * s.unit, s.ink)


def _piping(s: Sketch) -> None:
    """Draw vessels and valves connected by single or double lines."""
    boxes = _grid(s, int(s.rng.integers(2, 6)), int(s.rng.integers(2, 4)), s.pick(0.3, 0.6))
    pen, is_double = s.pen(), s.chance(0.5)
    for first, second in pairwise(boxes):
        ends = [np.array([(r[0] + r[2]) / 2, (r[1] + r[3]) / 2]) for r in (first, second)]
        line = _elbow(ends[0], ends[1], s.chance(0.5))
        s.line(line, pen, 6 if is_double else 2)
        if is_double:
            s.line(line, s.paper, 3)
        x, y = ((line[0] + line[1]) / 2).tolist()
        v = 6 * s.unit
        s.line(
            np.array([(x - v, y - v), (x + v, y + v), (x + v, y - v), (x - v, y + v)]),
            pen,
            1.5,
            True,
        )
    for a, b, c, d in boxes:
        if s.chance(0.4):
            s.disc((a + c) / 2, (b + d) / 2, min(c - a, d - b) / 2, s.paper, None)
            s.disc((a + c) / 2, (b + d) / 2, min(c - a, d - b) / 2, pen, 2)
        else:
            s.box((a, b, c, d), s.paper, pen, 2)
        s.text(f'{s.rng.choice(list("PTVE"))}-{int(s.rng.integers(1, 400))}', a, d + 3, 8 * s.unit)


def _site_plan(s: Sketch) -> None:
    """Draw plots with outlines of houses and trees, but no rooms."""
    columns, rows = int(s.rng.integers(1, 6)), int(s.rng.integers(1, 5))
    look, pen = int(s.rng.integers(3)), s.pen()
    for a, b, c, d in _grid(s, columns, rows, s.pick(0.8, 1.0)):
        s.box((a, b, c, d), s.pale() if s.chance(0.4) else None, pen)
        w, h = (c - a) * s.pick(0.3, 0.7), (d - b) * s.pick(0.3, 0.7)
        x, y = s.pick(a, c - w), s.pick(b, d - h)
        rect = (int(x), int(y), int(x + w), int(y + h))
        s.box(rect, s.colour(100, 220) if look == 0 else None, s.ink, s.pick(1, 5))
        if look == 1:
            hatched(s, rect, pen, s.unit * s.pick(4, 12))
        elif s.chance(0.4):  # a roof's ridges
            s.line(np.array([(x, y), (x + w / 3, y + h / 2), (x, y + h)]), pen)
            s.line(np.array([(x + w, y), (x + w - w / 3, y + h / 2), (x + w, y + h)]), pen)
        s.text(f'{int(s.rng.integers(1, 200))}', x + w / 2, y + h / 2, 9 * s.unit, is_centred=True)
        for _ in range(int(s.rng.integers(0, 6))):
            s.disc(s.pick(a, c), s.pick(b, d), s.pick(3, 14) * s.unit, s.pen())


def _logos(s: Sketch) -> None:
    """Draw logos or key plans."""
    for rect in _grid(s, int(s.rng.integers(1, 5)), int(s.rng.integers(1, 4)), 0.6):
        (logo if s.chance(0.8) else key_plan)(s, rect)


def _blocks_only(s: Sketch) -> None:
    """Draw the blocks of a sheet without a plan."""
    for name in s.rng.choice(list(BLOCK_MAKERS), int(s.rng.integers(4, 14))).tolist():
        draw_block(s, name)


def _blank_page(s: Sketch) -> None:
    """Leave the page blank, or draw a frame or hatching."""
    width, height = s.size
    if s.chance(0.5):
        s.box((8, 8, width - 9, height - 9), None, s.ink, s.pick(1, 8))
    if s.chance(0.4):
        hatched(s, (0, 0, width, height), s.pale(), s.unit * s.pick(6, 60))


NEGATIVES: dict[str, Callable[[Sketch], None]] = {
    'photo': _blank_page,
    'circuit': _circuit,
    'flow chart': _flow_chart,
    'org chart': _org_chart,
    'spreadsheet': _spreadsheet,
    'chart': _chart,
    'street map': _street_map,
    'text page': _text_page,
    'comic': _comic,
    'facades': _facades,
    'wiring': _wiring,
    'piping': _piping,
    'site plan': _site_plan,
    'logos': _logos,
    'blocks': _blocks_only,
    'blank page': _blank_page,
}
"""Kinds of pictures; :func:`negative` handles ``photo`` separately."""
