# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Grounds around the building of varied sheets: lawn, roads, trees, neighbours, terraces."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from fpnet_lab.sim.sheets.blocks import hatched
from fpnet_lab.sim.sheets.sketch import Array, Sketch, smooth_noise

# All sizes, counts and colours here are chosen, not measured.

_COARSE_PX = 260  # numerical: longer side of the raster for finding contours


@dataclass
class Grounds:
    """
    The grounds of a building in a picture.

    Parameters
    ----------
    s : the drawing surface; parts over the building are removed later
    built : the building's shape, y down [px]
    per_m : pixels per metre
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
        """Return closed lines (V, 2) around the building at a distance of ``far_px``."""
        style = 'round' if is_round else 'mitre'
        grown = shapely.buffer(self.built, far_px, join_style=style)
        return [
            shapely.get_coordinates(part.exterior)
            for part in shapely.get_parts(grown).tolist()
            if part.geom_type == 'Polygon'
        ]

    @property
    def gap(self) -> float:
        """Random short distance from the building [px]."""
        width, height = self.s.size
        return float(self.s.rng.uniform(0.008, 0.05)) * max(width, height)


def contours(site: Grounds) -> None:
    """Draw contour lines of the terrain, some of them closed around the building."""
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


def lawn(site: Grounds) -> None:
    """Fill all or part of the ground around the building, optionally dotted."""
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


def road(site: Grounds) -> None:
    """Draw a road past the building, with a centre line and a name."""
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
    x, y = middle.tolist()
    s.text(s.words(2), x, y, 0.3 * min(broad, 60 * s.unit), is_centred=True)


def parking(site: Grounds) -> None:
    """Draw a row of parking bays near the building, some with cars."""
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


def trees(site: Grounds) -> None:
    """Draw tree crowns in one style, some close to the building's walls."""
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


def hedge(site: Grounds) -> None:
    """Draw a row of bushes along lines around the building."""
    s = site.s
    radius = site.per_m * s.pick(0.4, 1.0)
    green, pen = s.colour(80, 220), s.pen()
    for ring in site.ring(site.gap * s.pick(1, 3)):
        line = shapely.LineString(ring)
        for at in np.linspace(0, s.pick(0.3, 1.0) * line.length, 90):
            point = line.interpolate(at)
            s.disc(point.x, point.y, radius, green, None)
            s.disc(point.x, point.y, radius, pen)


def neighbours(site: Grounds) -> None:
    """Draw other buildings: filled, hatched or outlined, some adjoining the building."""
    s = site.s
    width, height = s.size
    left, top, right, bottom = site.bounds
    look, grey = int(s.rng.integers(4)), s.colour(110, 225) if s.chance(0.3) else None
    fill = grey or (int(s.rng.integers(120, 230)),) * 3
    pen = s.pen()
    for _ in range(int(s.rng.integers(1, 7))):
        w, h = s.pick(0.08, 0.4) * width, s.pick(0.08, 0.4) * height
        x, y = s.pick(-0.1, 0.9) * width, s.pick(-0.1, 0.9) * height
        if s.chance(0.3):  # adjoining
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


def terrace(site: Grounds) -> None:
    """Draw tiled decks or slabs that touch the building."""
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


def pool(site: Grounds) -> None:
    """Draw a pool near the building."""
    s = site.s
    left, top, right, bottom = site.bounds
    w, h = site.per_m * s.pick(3, 12), site.per_m * s.pick(2.5, 6)
    x = s.pick(left - w, right)
    y = bottom + site.gap if s.chance(0.5) else top - site.gap - h
    ring = shapely.get_coordinates(shapely.box(x, y, x + w, y + h).buffer(s.pick(0, 0.3) * h))
    s.fill(ring, (int(s.rng.integers(100, 190)), 205, 235))
    s.line(ring, s.pen(), 2.0, is_closed=True)


def court(site: Grounds) -> None:
    """Draw lawn, paving or trees in the building's courtyards."""
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


def boundary(site: Grounds) -> None:
    """Draw a plot boundary with posts."""
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
