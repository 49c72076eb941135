# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is drawn close to and around a building on varied sheets: site, dimensions, neighbours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from fpnet_lab.sim.sheets.blocks import hatched
from fpnet_lab.sim.sheets.sketch import Array, Rgb, Sketch, smooth_noise

# All sizes, counts and colours here are chosen, not measured.

_COARSE_PX = 260  # numerical: contours are found on a raster so large


@dataclass
class Site:
    """
    A building on a picture.

    Parameters
    ----------
    s : what is drawn on; what lies on the building is cut out later
    built : all that is built, y down [px]
    per_m : pixels in a metre
    """

    s: Sketch
    built: BaseGeometry
    per_m: float

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Left, top, right and bottom of the building [px]."""
        a, b, c, d = self.built.bounds
        return a, b, c, d

    def ring(self, far_px: float, is_round: bool = False) -> list[Array]:
        """Return closed lines (V, 2) so far around the building."""
        style = 'round' if is_round else 'mitre'
        grown = shapely.buffer(self.built, far_px, join_style=style)
        return [
            shapely.get_coordinates(part.exterior)
            for part in shapely.get_parts(grown).tolist()
            if part.geom_type == 'Polygon'
        ]

    @property
    def gap(self) -> float:
        """A short way from the building [px]."""
        width, height = self.s.size
        return float(self.s.rng.uniform(0.008, 0.05)) * max(width, height)


def contours(site: Site) -> None:
    """Draw lines of equal height, some of which close around the building."""
    s = site.s
    width, height = s.size
    f = _COARSE_PX / max(width, height)
    shape = (max(8, int(f * height)), max(8, int(f * width)))
    away = np.full(shape, 255, np.uint8)
    for part in shapely.get_parts(site.built).tolist():
        ring = np.rint(f * shapely.get_coordinates(part.exterior)).astype(np.int32)
        cv2.fillPoly(away, [ring], 0)
    far = cv2.distanceTransform(away, cv2.DIST_L2, 3) / max(shape)
    ground = smooth_noise(s.rng, shape, int(s.rng.integers(3, 8)))
    field = s.pick(0.0, 1.5) * far + s.pick(0.1, 0.6) * ground
    field = cv2.GaussianBlur(field, (0, 0), 2.0)
    colour = s.colour(60, 200) if s.chance(0.6) else s.pen()
    pens = s.pick(0.7, 2.0)
    for level in np.linspace(field.min(), field.max(), int(s.rng.integers(5, 26)))[1:-1]:
        above = (field > level).astype(np.uint8)
        lines, _ = cv2.findContours(above, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
        for line in lines:
            if len(line) > 12:
                points = line[:, 0].astype(np.float64)
                kernel = np.ones(7) / 7
                padded = np.vstack([points[-3:], points, points[:3]])
                smooth = [np.convolve(padded[:, k], kernel, 'valid') for k in (0, 1)]
                s.line((np.stack(smooth, 1) + 0.5) / f, colour, pens, is_closed=True)


def lawn(site: Site) -> None:
    """Fill ground around the building, perhaps only a part, perhaps dotted."""
    s = site.s
    colour = (s.pale(), s.colour(150, 235), (190, 220, 170), (150, 190, 120))[
        int(s.rng.integers(4))
    ]
    if s.chance(0.4):
        s.pixels[:] = colour
    else:
        for ring in site.ring(site.gap * s.pick(0.6, 4.0), is_round=s.chance(0.5)):
            s.fill(ring, colour)
    if s.chance(0.4):
        width, height = s.size
        for x, y in s.rng.uniform((0, 0), (width, height), (600, 2)).tolist():
            s.disc(x, y, s.unit, s.pen(), None)


def road(site: Site) -> None:
    """Draw a road past the building, with a line in the middle and a name."""
    s = site.s
    width, height = s.size
    left, top, right, bottom = site.bounds
    broad = site.per_m * s.pick(3.0, 9.0)
    t = np.linspace(-0.1, 1.1, 40)
    sway = s.pick(0.0, 0.06) * np.sin(s.pick(1, 6) * t + s.pick(0, 6))
    far = site.gap + broad / 2.0
    if s.chance(0.5):
        y = (top - far if s.chance(0.5) else bottom + far) + sway * height
        line = np.stack([t * width, y], axis=1)
    else:
        x = (left - far if s.chance(0.5) else right + far) + sway * width
        line = np.stack([x, t * height], axis=1)
    band = shapely.LineString(line).buffer(broad / 2.0, cap_style='flat')
    if s.chance(0.6):
        s.fill(shapely.get_coordinates(band.exterior), s.colour(150, 240))
    pen = s.pen()
    for side in (-broad / 2.0, broad / 2.0):
        edge = shapely.LineString(line).parallel_offset(side)
        if edge.geom_type == 'LineString':
            s.line(shapely.get_coordinates(edge), pen, s.pick(1, 3))
    if s.chance(0.5):
        s.dashed(line[::3], pen, 1.0, 10.0 * s.unit)
    middle = line[int(s.rng.integers(8, 30))]
    s.text(s.words(2), *middle.tolist(), 0.3 * min(broad, 60 * s.unit), is_centred=True)


def parking(site: Site) -> None:
    """Draw a row of bays, some with cars, near the building."""
    s = site.s
    left, top, right, bottom = site.bounds
    wide, deep = 2.5 * site.per_m, 5.0 * site.per_m
    count = int(s.rng.integers(4, 20))
    is_row = s.chance(0.6)
    x = s.pick(left, right) - count * wide / 2 * is_row
    y = s.pick(top, bottom) - count * wide / 2 * (not is_row)
    far = site.gap
    if is_row:
        y = top - far - deep if s.chance(0.5) else bottom + far
    else:
        x = left - far - deep if s.chance(0.5) else right + far
    pen = s.pen()
    for i in range(count + 1):
        if is_row:
            a = (x + i * wide, y)
            b, car = (a[0], y + deep), (a[0] + 0.15 * wide, y + 0.1 * deep, 0.7 * wide, 0.8 * deep)
        else:
            a = (x, y + i * wide)
            b, car = (x + deep, a[1]), (x + 0.1 * deep, a[1] + 0.15 * wide, 0.8 * deep, 0.7 * wide)
        s.line(np.array([a, b]), pen)
        if i < count and s.chance(0.3):
            u, v, w, h = car
            rect = (int(u), int(v), int(u + w), int(v + h))
            s.box(rect, s.colour(100) if s.chance(0.4) else None, pen)


def trees(site: Site) -> None:
    """Draw crowns of one look, some near the building's walls."""
    s = site.s
    width, height = s.size
    look = int(s.rng.integers(5))
    green = (90, 150, 80) if s.chance(0.5) else s.colour(60, 230)
    pen = s.pen()
    for _ in range(int(s.rng.integers(5, 45))):
        radius = site.per_m * s.pick(0.7, 3.5)
        x, y = s.pick(0, width), s.pick(0, height)
        if site.built.distance(shapely.Point(x, y)) < 0.6 * radius:
            continue
        angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
        wave = 1.0 + (0.12 * np.sin(9 * angle) if look > 2 else 0.0)
        ring = radius * np.stack([wave * np.cos(angle), wave * np.sin(angle)], 1) + (x, y)
        if look in {1, 3}:
            s.fill(ring, green)
        s.line(ring, pen, is_closed=True)
        if look in {0, 2}:
            for i in range(0, 40, 5):
                s.line(np.array([(x, y), ring[i]]), pen, 0.7)
        if look == 4:
            s.disc(x, y, 0.1 * radius, pen, None)


def hedge(site: Site) -> None:
    """Draw a row of bushes along a line around the building."""
    s = site.s
    radius = site.per_m * s.pick(0.4, 1.0)
    green, pen = s.colour(80, 220), s.pen()
    for ring in site.ring(site.gap * s.pick(1, 3)):
        line = shapely.LineString(ring)
        for at in np.linspace(0, s.pick(0.3, 1.0) * line.length, 90):
            point = line.interpolate(at)
            s.disc(point.x, point.y, radius, green, None)
            s.disc(point.x, point.y, radius, pen)


def neighbours(site: Site) -> None:
    """Draw outlines of other buildings: filled, hatched or bare, some wall to wall."""
    s = site.s
    width, height = s.size
    left, top, right, bottom = site.bounds
    look, grey = int(s.rng.integers(4)), s.colour(110, 225) if s.chance(0.3) else None
    fill = grey or (int(s.rng.integers(120, 230)),) * 3
    pen = s.pen()
    for _ in range(int(s.rng.integers(1, 7))):
        w, h = s.pick(0.08, 0.4) * width, s.pick(0.08, 0.4) * height
        x, y = s.pick(-0.1, 0.9) * width, s.pick(-0.1, 0.9) * height
        if s.chance(0.3):  # wall to wall
            x = left - w if s.chance(0.5) else right
            y = s.pick(top - h / 2, bottom - h / 2)
        rect = (int(x), int(y), int(x + w), int(y + h))
        if look == 0:
            s.box(rect, fill, pen, 1.5)
        elif look == 1:
            hatched(s, rect, pen, s.unit * s.pick(4, 14))
            s.box(rect, None, pen, s.pick(1, 4))
        else:
            s.box(rect, None, pen, s.pick(1, 5))
            if look == 3:
                s.line(np.array([rect[:2], rect[2:]], float), pen)


def terrace(site: Site) -> None:
    """Draw a tiled deck or slab that touches the building."""
    s = site.s
    left, top, right, bottom = site.bounds
    for _ in range(int(s.rng.integers(1, 4))):
        wide, deep = s.pick(0.15, 0.9) * (right - left), site.per_m * s.pick(1.5, 7)
        high = s.pick(0.15, 0.9) * (bottom - top)
        x, y = s.pick(left, right - wide), s.pick(top, bottom - high)
        shape = (
            (x, top - deep, x + wide, (top + bottom) / 2),
            (x, (top + bottom) / 2, x + wide, bottom + deep),
            (left - deep, y, (left + right) / 2, y + high),
            ((left + right) / 2, y, right + deep, y + high),
        )[int(s.rng.integers(4))]
        a, b, c, d = shape
        rect = (int(a), int(b), int(c), int(d))
        pen = s.pen()
        s.box(rect, s.pale() if s.chance(0.7) else s.paper)
        gap = max(site.per_m * s.pick(0.15, 1.0), 4 * s.unit)
        pick = s.rng.random()
        if pick < 0.75:
            for at in np.arange(a, c, gap) if pick > 0.25 else ():
                s.line(np.array([(at, b), (at, d)]), pen, 0.7)
            for at in np.arange(b, d, gap) if pick < 0.6 else ():
                s.line(np.array([(a, at), (c, at)]), pen, 0.7)
        s.box(rect, None, pen, s.pick(1, 4))


def pool(site: Site) -> None:
    """Draw a pool near the building."""
    s = site.s
    left, top, right, bottom = site.bounds
    w, h = site.per_m * s.pick(3, 12), site.per_m * s.pick(2.5, 6)
    x = s.pick(left - w, right)
    y = bottom + site.gap if s.chance(0.5) else top - site.gap - h
    ring = shapely.get_coordinates(shapely.box(x, y, x + w, y + h).buffer(s.pick(0, 0.3) * h))
    s.fill(ring, (int(s.rng.integers(100, 190)), 205, 235))
    s.line(ring, s.pen(), 2.0, is_closed=True)


def court(site: Site) -> None:
    """Show courtyards within the building as lawn, paving or with trees."""
    s = site.s
    for part in shapely.get_parts(site.built).tolist():
        for hole in part.interiors:
            ring = shapely.get_coordinates(hole)
            pick = s.rng.random()
            if pick < 0.5:
                s.fill(ring, s.pale() if s.chance(0.5) else (170, 210, 150))
            (x0, y0), (x1, y1) = ring.min(axis=0), ring.max(axis=0)
            for _ in range(int(s.rng.integers(0, 9))):
                radius = site.per_m * s.pick(0.5, 2.5)
                x, y = s.pick(x0, x1), s.pick(y0, y1)
                s.disc(x, y, radius, s.pen(), None if s.chance(0.3) else 1.0)
            if pick > 0.7:
                s.line(np.array([(x0, y0), (x1, y1)]), s.pen())
                s.line(np.array([(x1, y0), (x0, y1)]), s.pen())


def boundary(site: Site) -> None:
    """Draw a plot's boundary with posts."""
    s = site.s
    hull = shapely.buffer(site.built.convex_hull, site.gap * s.pick(1, 4), join_style='mitre')
    ring = shapely.get_coordinates(hull.simplify(2 * site.gap))
    ring = ring + s.rng.normal(0, 0.3 * site.gap, (1, 2))
    colour = s.colour(0, 200) if s.chance(0.4) else s.pen()
    if s.chance(0.6):
        s.dashed(ring, colour, s.pick(1, 4), s.unit * s.pick(5, 16))
    else:
        s.line(ring, colour, s.pick(1, 4), is_closed=True)
    for x, y in ring.tolist():
        s.disc(x, y, 3 * s.unit, colour)


def eaves(site: Site) -> None:
    """Draw the roof's edge, dashed, around the building."""
    s = site.s
    colour = s.pen()
    for ring in site.ring(site.per_m * s.pick(0.3, 1.5)):
        s.dashed(ring, colour, s.pick(1, 2), s.unit * s.pick(4, 10))


def near_frame(site: Site) -> None:
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


def dimensions(site: Site) -> None:
    """Draw chains of dimensions at one to four sides, in one to three rows."""
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
    site: Site,
    spans: tuple[float, float, float, float],
    is_level: bool,
    ends: int,
    text: str,
    colour: Rgb,
) -> None:
    """Draw one length: its line, feet, and ends as ticks, arrows, dots or bare."""
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
                [(x, at), (x + 2 * inwards * tick, at + tick), (x + 2 * inwards * tick, at - tick)]
            )
            s.fill(tip, colour)
        elif ends == 2:
            spot = put([(x, at)])[0]
            s.disc(float(spot[0]), float(spot[1]), 0.6 * tick, colour, None)
    height = 6 * s.unit
    if b - a > 3.5 * height:
        x, y = put([((a + b) / 2, at - height)])[0].tolist()
        s.text(text, x, y, height, colour, is_centred=True, is_upright=not is_level)


Maker = Callable[[Site], None]

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
"""What is drawn around a building, the lowest first."""


def axes(site: Site) -> None:
    """Draw axes right across with bubbles on any sides."""
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


def section(site: Site) -> None:
    """Draw lines of sections right across the sheet, with arrows and letters."""
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


def leaders(site: Site) -> None:
    """Draw notes beside the building with lines that point into it."""
    s = site.s
    left, top, right, bottom = site.bounds
    colour = s.pen()
    for _ in range(int(s.rng.integers(1, 9))):
        is_right = s.chance(0.5)
        tip = np.array([s.pick(left, right), s.pick(top, bottom)])
        x = right + site.gap if is_right else left - site.gap
        y = s.pick(top, bottom)
        s.line(np.stack([tip, (x, y)]), colour)
        s.disc(*tip.tolist(), 2 * s.unit, colour, None)
        height = s.unit * s.pick(5, 9)
        text = s.words(int(s.rng.integers(1, 4)))
        start = x + 3 if is_right else x - 0.8 * height * len(text) - 3
        s.text(text, start, y - height / 2, height, colour)


OVER_MAKERS: dict[str, Maker] = {'axes': axes, 'section': section, 'leaders': leaders}
"""What is drawn across a building."""
