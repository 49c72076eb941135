# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reframing of a varied sheet's picture, and drawing of its surroundings."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
import shapely
from shapely.geometry.base import BaseGeometry

from fpnet_core.raster.pixels import map_points
from fpnet_lab.sim.sheets.blocks import BLOCK_MAKERS, draw_block, strip
from fpnet_lab.sim.sheets.grounds import Grounds
from fpnet_lab.sim.sheets.looks import Look
from fpnet_lab.sim.sheets.picture_effects import scaling
from fpnet_lab.sim.sheets.sketch import Array, Pixels, Rgb, Sketch, blank
from fpnet_lab.sim.sheets.storeys import PlacedStorey
from fpnet_lab.sim.sheets.surround_marks import AROUND_MAKERS, OVER_MAKERS
from fpnet_lab.sim.sheets.surround_style import AROUND, BLOCKS, OVER, STRIPS, SurroundStyle

# Chosen, not measured:
_LONGEST_PX, _LONGEST_SHRUNK_PX = (1300.0, 3400.0), 1400.0
_CROP_MARGIN = (-0.003, 0.03)  # margin around a cropped building relative to its longer side
_PAD = (0.02, 0.5)
_SMALL_SHARE = (0.15, 0.33)  # building's share of a large sheet's longer side
_UNIT_PX = 1300.0  # longer side of a picture with one-pixel lines
_CLEAR_PX = 2.0  # margin around the building that stays clear
_DARK = 110  # paper with a lower mean gets light ink
_LEAST_PX = 60


def surrounded(
    pixels: Pixels,
    H_image_page: Array,
    storeys: Sequence[PlacedStorey],
    look: Look,
    outer_m: float,
) -> tuple[Pixels, Array]:
    """
    Return a sheet's picture with its surroundings, and the page's homography to it.

    Parameters
    ----------
    pixels : (H, W, 3) as drawn
    H_image_page : (3, 3) from page metres to these pixels
    storeys : storeys on the sheet
    look : style; its ``surround`` selects the components
    outer_m : drawn thickness of outer walls
    """
    style = look.surround
    if style is None:
        return pixels, H_image_page
    rng = np.random.default_rng(style.seed)
    paper = _paper(pixels)
    ink = _ink(look, paper)
    shell = shapely.union_all([storey.shell(outer_m) for storey in storeys])
    pixels, H = _framed(pixels, H_image_page, shell, style, paper, rng)
    built = _mapped(shell, H)
    per_m = float(np.sqrt(abs(np.linalg.det(H[:2, :2]))))
    unit = float(np.clip(max(pixels.shape[:2]) / _UNIT_PX * rng.uniform(0.8, 1.6), 0.6, 4.0))
    _around(pixels, Grounds(Sketch(pixels, rng, ink, paper, unit), built, per_m), style)
    site = Grounds(Sketch(pixels, rng, ink, paper, unit), built, per_m)
    _beside(site, style)
    for name in OVER:
        if name in style.parts:
            OVER_MAKERS[name](site)
    pixels, S = _with_strips(site.s, style)
    return pixels, S @ H


def _paper(pixels: Pixels) -> Rgb:
    edge = np.concatenate([pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]])
    r, g, b = np.median(edge, axis=0).astype(int).tolist()
    return r, g, b


def _ink(look: Look, paper: Rgb) -> Rgb:
    """Return the colour of lines, light on dark paper."""
    is_dark = sum(paper) < 3 * _DARK
    r, g, b = (round(255 * (1.0 - c if is_dark else c)) for c in look.line)
    return r, g, b


def _mapped(shape: BaseGeometry, H: Array) -> BaseGeometry:
    return shapely.transform(shape, lambda points: map_points(H, points))


def _framed(
    pixels: Pixels,
    H: Array,
    shell: BaseGeometry,
    style: SurroundStyle,
    paper: Rgb,
    rng: np.random.Generator,
) -> tuple[Pixels, Array]:
    """Return the picture cropped or padded and limited in size, and its homography (3, 3)."""
    height, width = pixels.shape[:2]
    left, top, right, bottom = _mapped(shell, H).bounds
    longer = max(right - left, bottom - top)
    a, b, c, d = 0.0, 0.0, float(width), float(height)
    if style.framing == 'cropped':
        margins = rng.uniform(*_CROP_MARGIN, 4) * longer
        a, b, c, d = left - margins[0], top - margins[1], right + margins[2], bottom + margins[3]
    elif style.framing == 'padded':
        pads = rng.uniform(*_PAD, 4) * (rng.random(4) < 0.6) * longer
        a, b, c, d = a - pads[0], b - pads[1], c + pads[2], d + pads[3]
    elif style.framing == 'small on a large sheet':
        side = longer / float(rng.uniform(*_SMALL_SHARE))
        across = side * float(rng.uniform(0.6, 1.0))
        wide, high = (side, across) if rng.random() < 0.6 else (across, side)
        wide, high = max(wide, c), max(high, d)
        a, b = -rng.random(2) * (wide - c, high - d)
        c, d = a + wide, b + high
    corner = np.floor([a, b])
    size = np.maximum(np.ceil([c, d] - corner), _LEAST_PX)
    low, high = np.log(_LONGEST_PX)
    longest = float(np.exp(rng.uniform(low, high)))
    if 'shrink' in style.effects:
        longest = min(longest, _LONGEST_SHRUNK_PX)
    f = min(1.0, longest / float(size.max()))
    S = np.eye(3)
    if f < 1.0:
        small = (max(1, round(f * width)), max(1, round(f * height)))
        pixels = np.asarray(cv2.resize(pixels, small, interpolation=cv2.INTER_AREA), np.uint8)
        S = scaling(small[0] / width, small[1] / height)
    columns, rows = np.maximum(np.rint(f * size), 8).astype(int).tolist()
    at = np.rint(-f * corner).astype(int).tolist()
    T = np.eye(3)
    T[:2, 2] = at
    return _pasted(pixels, (at[0], at[1]), (rows, columns), paper), T @ S @ H


def _pasted(pixels: Pixels, at: tuple[int, int], shape: tuple[int, int], paper: Rgb) -> Pixels:
    """Return paper (H, W, 3) with the picture's upper left corner at ``at`` (x, y)."""
    found = blank(shape, paper)
    x, y = at
    left, top = max(x, 0), max(y, 0)
    right, bottom = min(x + pixels.shape[1], shape[1]), min(y + pixels.shape[0], shape[0])
    if right > left and bottom > top:
        found[top:bottom, left:right] = pixels[top - y : bottom - y, left - x : right - x]
    return found


def _painted(shape: tuple[int, int], area: BaseGeometry) -> NDArray[np.bool_]:
    """Return the mask (H, W) of an area."""
    mask = np.zeros(shape, np.uint8)
    for part in shapely.get_parts(area).tolist():
        if part.geom_type == 'Polygon':
            rings = [part.exterior, *part.interiors]
            corners = [np.rint(shapely.get_coordinates(r)).astype(np.int32) for r in rings]
            cv2.fillPoly(mask, corners, 1)
    return mask.astype(np.bool_)


def _around(pixels: Pixels, site: Grounds, style: SurroundStyle) -> None:
    """Draw the surroundings of the building in place, below existing content."""
    names = [name for name in AROUND if name in style.parts]
    if not names:
        return
    shape = pixels.shape[:2]
    layer = blank((shape[0], shape[1]), site.s.paper)
    site.s.pixels = layer
    for name in AROUND_MAKERS:
        if name in names:
            AROUND_MAKERS[name](site)
    drawn = np.maximum(pixels, layer) if site.s.is_dark else np.minimum(pixels, layer)
    grown = shapely.buffer(site.built, _CLEAR_PX, join_style='mitre')
    keep = _painted((shape[0], shape[1]), grown)
    np.copyto(pixels, drawn, where=~keep[..., None])


def _beside(site: Grounds, style: SurroundStyle) -> None:
    """Draw blocks in free places around the building, and a frame along the paper's edge."""
    s = site.s
    names = [name for name in BLOCKS if name in style.parts]
    if not names:
        return
    far = s.pick(1.0, 14.0) * s.unit + _CLEAR_PX
    if len(site.built.bounds):
        grown = shapely.buffer(site.built, far, join_style='mitre')
        solid = shapely.union_all(
            [
                shapely.Polygon(part.exterior)
                for part in shapely.get_parts(grown).tolist()
                if part.geom_type == 'Polygon'
            ]
        )
        s.taken = _painted((s.size[1], s.size[0]), solid)
    if 'frame' in names:
        _edge_frame(site)
    for name in s.rng.permutation([name for name in names if name in BLOCK_MAKERS]).tolist():
        for _ in range(1 + int(s.rng.random() < 0.25)):
            draw_block(s, name)


def _edge_frame(site: Grounds) -> None:
    """Draw up to three frames along the paper's edge, if they do not touch the building."""
    s = site.s
    width, height = s.size
    left, top, right, bottom = site.bounds
    room = min(left, top, width - right, height - bottom)
    inset = int(s.pick(0.0, 0.04) * max(width, height))
    pens = s.pick(1, 14)
    for _ in range(int(s.rng.integers(1, 4))):
        if inset + s.width(pens) >= room:
            return
        s.box((inset, inset, width - 1 - inset, height - 1 - inset), None, s.pen(), pens)
        inset += s.width(pens) + int(s.pick(2, 12) * s.unit)
        pens = s.pick(1, 4)


def _with_strips(s: Sketch, style: SurroundStyle) -> tuple[Pixels, Array]:
    """Return the picture with toolbar, banner, footer and column, and its map (3, 3)."""
    S = np.eye(3)
    pixels = s.pixels
    for name in STRIPS:
        if name not in style.parts:
            continue
        height, width = pixels.shape[:2]
        if name == 'column':
            part = strip(s, name, (height, max(30, int(s.pick(0.1, 0.3) * width))))
            is_first = s.chance(0.25)
            pixels = np.hstack([part, pixels] if is_first else [pixels, part])
            S[0, 2] += part.shape[1] if is_first else 0
        else:
            part = strip(s, name, (max(16, int(s.pick(0.03, 0.12) * height)), width))
            is_first = name != 'footer'
            pixels = np.vstack([part, pixels] if is_first else [pixels, part])
            S[1, 2] += part.shape[0] if is_first else 0
    return np.ascontiguousarray(pixels), S
