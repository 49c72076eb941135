# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Blocks beside the plan on a sheet: tables, notes, photos, elevations, key plans."""

from __future__ import annotations

from collections.abc import Callable
import itertools

import cv2
import numpy as np

from fpnet_lab.sim.sheets.sketch import Rect, Rgb, Sketch, blank, smooth_noise

# All sizes, counts and colours here are chosen, not measured.


def table(s: Sketch, rect: Rect) -> None:
    """Draw a table of words and numbers."""
    left, top, right, bottom = rect
    rows = max(2, min(int(s.rng.integers(3, 30)), (bottom - top) // max(6, s.width(7))))
    columns = int(s.rng.integers(2, 7))
    ys = np.linspace(top, bottom, rows + 1)
    xs = np.sort(np.r_[left, right, s.rng.uniform(left, right, columns - 1)])
    pen = s.pen()
    if s.chance(0.5):
        s.box((left, top, right, int(ys[1])), s.pale() if s.chance(0.6) else s.colour(0, 120))
    if s.chance(0.3):
        for y0, y1 in zip(ys[1::2], ys[2::2], strict=False):
            s.box((left, int(y0), right, int(y1)), s.pale())
    if s.chance(0.85):
        for y in ys:
            s.line(np.array([(left, y), (right, y)]), pen)
    if s.chance(0.7):
        for x in xs:
            s.line(np.array([(x, top), (x, bottom)]), pen)
    height = 0.5 * (bottom - top) / rows
    for y in ys[:-1]:
        for a, b in itertools.pairwise(xs):
            if b - a > 2.0 * height and s.chance(0.85):
                word = s.words(1) if s.chance(0.5) else f'{s.pick(0, 200):.2f}'
                s.text(word, a + 3, y + 0.4 * height, height, most_px=b - a - 6)


def title_block(s: Sketch, rect: Rect) -> None:
    """Draw nested boxes with texts and optionally a logo."""
    left, top, right, bottom = rect
    s.box(rect, s.paper if s.chance(0.7) else s.pale(), s.pen(), s.pick(1, 4))
    ys = np.unique(np.rint(np.sort(np.r_[top, bottom, s.rng.uniform(top, bottom, 6)])))
    pen = s.pen()
    for y0, y1 in zip(ys[:-1].tolist(), ys[1:].tolist(), strict=True):
        s.line(np.array([(left, y1), (right, y1)]), pen)
        pick = s.rng.random()
        if pick < 0.2:
            logo(s, (left + 4, int(y0) + 3, int(left + 0.4 * (right - left)), int(y1) - 3))
        elif pick < 0.35:
            table(s, (left, int(y0), right, int(y1)))
        else:
            height = min(0.6 * (y1 - y0), s.unit * s.pick(8, 24))
            s.text(s.words(3), left + 5, y0 + 3, height, most_px=0.9 * (right - left))


def legend(s: Sketch, rect: Rect) -> None:
    """Draw colour swatches or hatches with names."""
    left, top, right, bottom = rect
    step = int(s.unit * s.pick(14, 26))
    if s.chance(0.5):
        s.box(rect, s.paper, s.pen())
    for y in range(top + 3, bottom - step, step):
        swatch = (left + 4, y + 2, left + 4 + int(1.3 * step), y + step - 4)
        if swatch[2] > right - 4:
            return
        pick = s.rng.random()
        s.box(swatch, s.colour(90, 256) if pick < 0.6 else None, s.pen() if pick > 0.3 else None)
        if pick > 0.8:
            hatched(s, swatch, s.ink, max(3.0, step / 5.0))
        s.text(s.words(2), swatch[2] + 5, y + 3, 0.5 * step, most_px=right - swatch[2] - 8)


def hatched(s: Sketch, rect: Rect, colour: Rgb, gap: float) -> None:
    """Draw diagonal hatching in a rectangle."""
    left, top, right, bottom = rect
    part = s.pixels[max(top, 0) : bottom, max(left, 0) : right]
    height, width = part.shape[:2]
    if not height or not width:
        return
    copy = np.ascontiguousarray(part)
    for at in np.arange(-height, width, gap).tolist():
        ends = (round(at), height), (round(at + height), 0)
        cv2.line(copy, *ends, colour, s.width(0.7), cv2.LINE_AA)
    part[:] = copy


def key_plan(s: Sketch, rect: Rect) -> None:
    """Draw a small outline of a building with one part filled."""
    left, top, right, bottom = rect
    x, y = np.meshgrid(np.linspace(left, right, 4), np.linspace(top, bottom, 4))
    kept = s.rng.random((3, 3)) < 0.7
    pick = int(s.rng.integers(9))
    pen, strong = s.pen(), s.colour(0, 200)
    for i in range(9):
        r, c = divmod(i, 3)
        box = (int(x[r, c]), int(y[r, c]), int(x[r + 1, c + 1]), int(y[r + 1, c + 1]))
        if i == pick:
            s.box(box, strong, pen, 2.0)
        elif kept[r, c]:
            s.box(box, s.pale() if s.chance(0.5) else None, pen, s.pick(1, 3))
    s.text(s.words(1), left, bottom + 3, 9 * s.unit)


def photo(s: Sketch, rect: Rect) -> None:
    """Paste a photo-like scene of boxes, blobs and noise."""
    left, top, right, bottom = rect
    s.pixels[top:bottom, left:right] = scene(s.rng, (bottom - top, right - left))
    if s.chance(0.4):
        s.box(rect, None, s.pen(), s.pick(1, 3))


def scene(rng: np.random.Generator, shape: tuple[int, int]) -> np.ndarray:
    """Return a photo-like scene (H, W, 3)."""
    height, width = shape
    field = np.stack([smooth_noise(rng, shape, int(rng.integers(3, 12))) for _ in range(3)], 2)
    base = rng.uniform(30.0, 220.0, (2, 3)).astype(np.float32)
    ramp = np.linspace(0.0, 1.0, height, dtype=np.float32)[:, None, None]
    shown = base[0] * (1.0 - ramp) + base[1] * ramp + rng.uniform(10.0, 110.0) * (field - 0.5)
    pixels = np.ascontiguousarray(np.clip(shown, 0, 255).astype(np.uint8))
    for _ in range(int(rng.integers(3, 30))):
        colour = tuple(rng.integers(0, 256, 3).tolist())
        x, y = int(rng.integers(width)), int(rng.integers(height))
        w, h = (int(rng.uniform(0.02, 0.3) * side) + 1 for side in (width, height))
        pick = rng.random()
        if pick < 0.4:
            cv2.rectangle(pixels, (x, y), (x + w, y + h), colour, -1)
        elif pick < 0.7:
            angle = float(rng.uniform(0, 180))
            cv2.ellipse(pixels, (x, y), (w // 2 + 1, h // 2 + 1), angle, 0, 360, colour, -1)
        elif pick < 0.85:  # a person
            cv2.ellipse(pixels, (x, y), (h // 5 + 1, h // 2 + 1), 0, 0, 360, colour, -1)
            cv2.circle(pixels, (x, y - h // 2 - h // 6), h // 6 + 1, colour, -1)
        else:
            corners = rng.integers(0, (width, height), (4, 2)).astype(np.int32)
            cv2.fillPoly(pixels, [corners], colour)
    blur = float(rng.uniform(0.3, 3.0))
    soft = cv2.GaussianBlur(pixels, (0, 0), blur).astype(np.float32)
    soft += rng.standard_normal(shape, np.float32)[..., None] * np.float32(rng.uniform(0, 14))
    return np.clip(soft, 0, 255).astype(np.uint8)


def gradient(s: Sketch, rect: Rect) -> None:
    """Paste a smooth gradient."""
    left, top, right, bottom = rect
    a, b = s.rng.uniform(0, 256, (2, 3)).astype(np.float32)
    ramp = np.linspace(0, 1, bottom - top, dtype=np.float32)[:, None, None]
    s.pixels[top:bottom, left:right] = (a + ramp * (b - a)).astype(np.uint8)


def elevation(s: Sketch, rect: Rect) -> None:
    """Draw a facade with windows, a door, a roof and the ground, or a section with storeys."""
    left, top, right, bottom = rect
    width, height = right - left, bottom - top
    pen, strong = s.ink, s.pick(1, 4)
    eaves = top + int(height * s.pick(0.05, 0.4))
    wall = (left + width // 12, eaves, right - width // 12, bottom)
    is_section = s.chance(0.3)
    s.box(wall, s.pale() if s.chance(0.5) else None, pen, strong)
    ridge = (left + right) / 2 if s.chance(0.6) else left + s.pick(0.1, 0.9) * width
    roof = np.array([(left, eaves), (ridge, top), (right, eaves)], float)
    if s.chance(0.4):
        s.fill(roof, s.colour(60, 220))
    s.line(roof, pen, strong, is_closed=True)
    storeys, bays = int(s.rng.integers(1, 6)), int(s.rng.integers(2, 12))
    ys = np.linspace(eaves, bottom, storeys + 1)
    xs = np.linspace(wall[0], wall[2], bays + 1)
    share = s.pick(0.35, 0.75)
    if is_section or s.chance(0.3):
        for y in ys[1:]:
            s.line(np.array([(wall[0], y), (wall[2], y)]), pen, strong)
    glass = s.colour(120, 250) if s.chance(0.4) else None
    for y0, y1 in itertools.pairwise(ys):
        for x0, x1 in itertools.pairwise(xs):
            if is_section:
                if s.chance(0.4):
                    s.line(np.array([(x0, y0), (x0, y1)]), pen, strong)
                continue
            dx, dy = (x1 - x0) * (1 - share) / 2, (y1 - y0) * (1 - share) / 2
            pane = (int(x0 + dx), int(y0 + dy), int(x1 - dx), int(y1 - dy))
            s.box(pane, glass, pen)
            if share > 0.5:
                middle = (x0 + x1) / 2
                s.line(np.array([(middle, pane[1]), (middle, pane[3])]), pen)
    s.line(np.array([(left - width / 20, bottom), (right + width / 20, bottom)]), pen, 2 * strong)


def paragraph(s: Sketch, rect: Rect) -> None:
    """Write lines of text, optionally numbered and in a box."""
    left, top, right, bottom = rect
    if s.chance(0.2):
        s.box(rect, s.pale() if s.chance(0.5) else None, s.pen())
    height = max(5.0, s.unit * s.pick(5, 11))
    y, number = float(top + 3), 1
    colour = s.pen()
    while y + 1.7 * height < bottom:
        prefix = f'{number}. ' if s.chance(0.3) else ''
        number += bool(prefix)
        share = 1.0 if s.chance(0.7) else s.pick(0.3, 0.9)
        count = max(1, int(share * (right - left) / (height * 4.6)))
        s.text(prefix + s.words(count), left + 4, y, height, colour, most_px=right - left - 8)
        y += 1.7 * height


def cloud(s: Sketch, rect: Rect) -> None:
    """Draw a revision cloud."""
    left, top, right, bottom = rect
    radius = max(3.0, s.unit * s.pick(5, 12))
    colour = s.colour(0, 220)
    xs, ys = np.arange(left, right, 1.7 * radius), np.arange(top, bottom, 1.7 * radius)
    spots = [(float(x), float(top), 180) for x in xs] + [(float(x), float(bottom), 0) for x in xs]
    spots += [(float(left), float(y), 90) for y in ys]
    spots += [(float(right), float(y), 270) for y in ys]
    for x, y, start in spots:
        at, size = (round(x), round(y)), (round(radius), round(radius))
        cv2.ellipse(s.pixels, at, size, 0, start, start + 180, colour, s.width(1.5), cv2.LINE_AA)


def stamp(s: Sketch, rect: Rect) -> None:
    """Draw a round or square stamp in one colour."""
    left, top, right, bottom = rect
    x, y, radius = (left + right) / 2, (top + bottom) / 2, min(right - left, bottom - top) / 2.2
    colour = s.colour(0, 200)
    if s.chance(0.5):
        s.disc(x, y, radius, colour, 2.0)
        s.disc(x, y, 0.75 * radius, colour)
    else:
        s.box(rect, None, colour, 2.5)
    s.text(s.words(1).upper(), x, y, 0.3 * radius, colour, is_centred=True, most_px=1.5 * radius)


def code(s: Sketch, rect: Rect) -> None:
    """Draw a QR code or a barcode."""
    left, top, right, bottom = rect
    side = min(right - left, bottom - top)
    cells = (s.rng.random((25, 25)) < 0.5).astype(np.uint8) * 255
    if s.chance(0.3):
        cells[:] = cells[:1]
    for r, c in ((0, 0), (0, 18), (18, 0)):
        cells[r : r + 7, c : c + 7] = 0
        cells[r + 1 : r + 6, c + 1 : c + 6] = 255
        cells[r + 2 : r + 5, c + 2 : c + 5] = 0
    big = cv2.resize(cells, (side, side), interpolation=cv2.INTER_NEAREST)
    s.pixels[top : top + side, left : left + side] = big[..., None]


def scale_bar(s: Sketch, rect: Rect) -> None:
    """Draw a scale bar of alternating blocks or ticks, labelled in metres or feet."""
    left, top, right, _ = rect
    count, height = int(s.rng.integers(2, 8)), s.unit * s.pick(3, 8)
    xs, step = np.linspace(left, right, count + 1), int(s.rng.choice([1, 2, 5, 10]))
    is_ticks, unit = s.chance(0.4), str(s.rng.choice(["'", ' ft', ' m', 'm']))
    for i, (a, b) in enumerate(itertools.pairwise(xs)):
        box = (int(a), top, int(b), int(top + height))
        if not is_ticks:
            s.box(box, s.ink if i % 2 == 0 else s.paper, s.ink)
        else:
            s.line(np.array([(a, top), (a, top + height), (b, top + height), (b, top)]), s.ink)
    for i, x in enumerate(xs):
        text = f'{i * step}' + (unit if i == count else '')
        s.text(text, x, top + 2.2 * height, s.unit * 6, is_centred=True)


def north(s: Sketch, rect: Rect) -> None:
    """Draw a north arrow in a random style."""
    left, top, right, bottom = rect
    x, y, radius = (left + right) / 2, (top + bottom) / 2, min(right - left, bottom - top) / 2.3
    angle = s.pick(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    shape = radius * np.array([(0, -1), (0.35, 0.8), (0, 0.45), (-0.35, 0.8)]) @ turn.T + (x, y)
    if s.chance(0.6):
        s.disc(x, y, radius, s.ink, s.pick(1, 3))
    if s.chance(0.5):
        s.fill(shape, s.ink)
    else:
        s.fill(shape[:3], s.ink)
        s.line(shape, s.ink, is_closed=True)
    if s.chance(0.5):
        s.line(np.array([(-radius, 0), (radius, 0)]) @ turn.T + (x, y), s.ink)
    tip = np.array([(0.0, -1.25 * radius)]) @ turn.T + (x, y)
    s.text('N', float(tip[0, 0]), float(tip[0, 1]), 0.4 * radius, is_centred=True)


def logo(s: Sketch, rect: Rect) -> None:
    """Draw simple coloured shapes with a name."""
    left, top, right, bottom = rect
    side = min(right - left, bottom - top)
    if side < 6:
        return
    x, y = left + side / 2, top + side / 2
    for _ in range(int(s.rng.integers(1, 4))):
        colour = s.colour()
        if s.chance(0.5):
            s.disc(x, y, side * s.pick(0.15, 0.45), colour, None if s.chance(0.6) else 3)
        else:
            corners = s.rng.uniform(-0.5, 0.5, (int(s.rng.integers(3, 6)), 2)) * side + (x, y)
            s.fill(corners, colour)
    s.text(s.words(1).upper(), left + side + 4, top + 0.3 * side, 0.3 * side, s.pen())


def headline(s: Sketch, rect: Rect) -> None:
    """Write a headline and a smaller line."""
    left, top, right, bottom = rect
    height = 0.5 * (bottom - top)
    s.text(s.words(2).title(), left, top, height, s.pen(), most_px=right - left)
    s.text(s.words(5), left, top + 1.4 * height, 0.4 * height, s.pen(), most_px=right - left)


def page_number(s: Sketch, rect: Rect) -> None:
    """Write a number."""
    s.text(f'{int(s.rng.integers(1, 300))}', rect[0], rect[1], s.unit * s.pick(7, 14))


def scribble(s: Sketch, rect: Rect) -> None:
    """Draw loops that resemble handwriting."""
    left, top, right, bottom = rect
    t = np.linspace(0, 1, 160)
    colour = s.colour(0, 180)
    for y in np.arange(top + 8, bottom - 4, s.unit * 18):
        size = s.unit * s.pick(3, 7)
        phase = np.cumsum(s.rng.uniform(0.1, 0.9, len(t)))
        x = left + t * (right - left) * s.pick(0.5, 0.95) + size * np.cos(phase)
        line = np.stack([x, y + size * np.sin(phase) * s.rng.uniform(0.4, 1.2, len(t))], 1)
        s.line(line, colour, s.pick(0.8, 2))


def nothing(s: Sketch, rect: Rect) -> None:
    """Draw nothing."""


Block = Callable[[Sketch, Rect], None]

BLOCK_MAKERS: dict[str, tuple[Block, tuple[float, float], tuple[float, float]]] = {
    'title block': (title_block, (0.15, 0.4), (0.1, 0.35)),
    'table': (table, (0.12, 0.4), (0.1, 0.5)),
    'legend': (legend, (0.1, 0.25), (0.08, 0.4)),
    'key plan': (key_plan, (0.06, 0.16), (0.06, 0.16)),
    'photo': (photo, (0.12, 0.45), (0.1, 0.4)),
    'gradient': (gradient, (0.1, 0.4), (0.08, 0.4)),
    'elevation': (elevation, (0.15, 0.5), (0.1, 0.3)),
    'paragraph': (paragraph, (0.12, 0.4), (0.06, 0.5)),
    'cloud': (cloud, (0.08, 0.3), (0.06, 0.3)),
    'stamp': (stamp, (0.06, 0.15), (0.05, 0.12)),
    'code': (code, (0.05, 0.12), (0.05, 0.12)),
    'scale bar': (scale_bar, (0.1, 0.35), (0.03, 0.05)),
    'north': (north, (0.05, 0.13), (0.05, 0.13)),
    'logo': (logo, (0.08, 0.2), (0.05, 0.12)),
    'page number': (page_number, (0.03, 0.05), (0.02, 0.04)),
    'headline': (headline, (0.2, 0.6), (0.04, 0.12)),
    'scribble': (scribble, (0.1, 0.3), (0.05, 0.2)),
}
"""Blocks with their ranges of width and height as shares of the picture; chosen."""


def draw_block(s: Sketch, name: str) -> None:
    """Draw a block in a free place, if there is one."""
    make, wide, high = BLOCK_MAKERS[name]
    width, height = s.size
    rect = s.free((wide[0] * width, wide[1] * width), (high[0] * height, high[1] * height))
    if rect is not None and min(rect[2] - rect[0], rect[3] - rect[1]) > 9:
        make(s, rect)


def strip(s: Sketch, name: str, shape: tuple[int, int]) -> np.ndarray:
    """Return a strip (H, W, 3) for one side of a picture: toolbar, banner, footer or column."""
    height, width = shape
    is_plain = name == 'column' or s.chance(0.2)
    ground = s.paper if is_plain else s.colour(0, 256)
    dark = sum(ground) < 380
    part = Sketch(
        blank(shape, ground),
        s.rng,
        (250, 250, 250) if dark else (15, 15, 15),
        ground,
        s.unit,
    )
    if name == 'column':
        part.box((3, 3, width - 4, height - 4), None, part.pen(), s.pick(1, 3))
        for block in s.rng.choice(list(BLOCK_MAKERS), int(s.rng.integers(2, 7))).tolist():
            make = BLOCK_MAKERS[block][0]
            rect = part.free((0.6 * width, 0.95 * width), (0.06 * height, 0.3 * height))
            if rect is not None:
                make(part, rect)
        return part.pixels
    text = 0.4 * height
    part.text(part.words(3).title(), s.pick(0.01, 0.3) * width, 0.3 * height, text)
    if name == 'toolbar' or s.chance(0.3):
        for x in np.arange(0.5 * width, width - height, s.pick(1.2, 2.5) * height).tolist():
            icon = (int(x), int(0.2 * height), int(x + 0.6 * height), int(0.8 * height))
            logo(part, icon) if s.chance(0.5) else part.box(icon, part.colour(), part.ink)
    return part.pixels
