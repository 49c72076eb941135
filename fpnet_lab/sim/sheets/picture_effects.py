# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Effects on a varied sheet's picture: tints, stains, overlays, rotation, shrinking."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_lab.sim.sheets.sketch import Array, Pixels, Sketch, smooth_noise
from fpnet_lab.sim.sheets.surround_style import SurroundStyle

# All strengths, sizes and colours here are chosen, not measured.

THUMBNAIL_PX = (350.0, 900.0)  # longer side of a shrunk picture; chosen
_LEAST_PX = 48  # minimum shorter side of a picture; chosen


def _sketch(pixels: Pixels, rng: np.random.Generator) -> Sketch:
    unit = float(np.clip(max(pixels.shape[:2]) / 1300.0, 0.6, 3.0))
    is_dark = float(pixels[::7, ::7].mean()) < 110.0
    ink, paper = ((230,) * 3, (20,) * 3) if is_dark else ((20,) * 3, (240,) * 3)
    return Sketch(pixels, rng, ink, paper, unit)


def marked(pixels: Pixels, style: SurroundStyle, wobble_px: float) -> Pixels:
    """
    Return the picture with marks and tints that do not change its geometry.

    Parameters
    ----------
    pixels : (H, W, 3)
    style : selects the effects
    wobble_px : maximum displacement of lines
    """
    rng = np.random.default_rng([style.seed, 1])
    for name, effect in _MARKS.items():
        if name in style.effects:
            pixels = effect(np.ascontiguousarray(pixels), rng)
    if 'wobble' in style.effects and wobble_px > 0.5:
        pixels = _wobble(pixels, rng, wobble_px)
    return pixels


def taken(pixels: Pixels, style: SurroundStyle) -> tuple[Pixels, Array]:
    """Return the picture rotated, shrunk and compressed, and the map (3, 3) of its pixels."""
    rng = np.random.default_rng([style.seed, 2])
    H = np.eye(3)
    if 'shrink' in style.effects:  # first, because it makes all other effects faster
        pixels, S = _shrunk(pixels, rng)
        H = S @ H
    if 'turn' in style.effects or 'skew' in style.effects:
        pixels, T = _turned(pixels, rng, style)
        H = T @ H
    for name, effect in _TAKEN.items():
        if name in style.effects:
            pixels = effect(np.ascontiguousarray(pixels), rng)
    return pixels, H


def _tint(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Tint the picture as blueprint, dark screen, sepia, coloured paper or greyscale."""
    grey = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY).astype(np.float32)[..., None] / 255.0
    pick = rng.random()
    if pick < 0.3:
        blue = np.array([rng.uniform(0, 60), rng.uniform(40, 110), rng.uniform(110, 200)])
        shown = grey * blue.astype(np.float32) + (1.0 - grey) * np.float32(rng.uniform(210, 255))
    elif pick < 0.5:
        ground = rng.uniform(10, 60, 3).astype(np.float32)
        shown = ground + (255.0 - pixels) * np.float32(rng.uniform(0.6, 0.85))
    elif pick < 0.65:
        shown = grey * np.array([240, 220, 180], np.float32) + (1 - grey) * np.float32(50)
    elif pick < 0.9:
        shown = pixels * rng.uniform(0.55, 1.0, 3).astype(np.float32)
    else:
        shown = np.repeat(255.0 * grey, 3, axis=2)
    return np.clip(shown, 0, 255).astype(np.uint8)


def _faint(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Fade lines like those of a hard pencil."""
    paper = float(rng.uniform(225, 255))
    shown = paper - (255.0 - pixels.astype(np.float32)) * np.float32(rng.uniform(0.35, 0.75))
    grain = rng.standard_normal(pixels.shape[:2], np.float32)[..., None]
    return np.clip(shown + grain * np.float32(rng.uniform(0, 6)), 0, 255).astype(np.uint8)


def _broken(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Remove ink at random places."""
    shape = (pixels.shape[0], pixels.shape[1])
    cells = int(rng.integers(20, max(22, min(max(shape) // 3, 400))))
    missing = smooth_noise(rng, shape, cells) < rng.uniform(0.05, 0.22)
    paper = np.median(pixels[::9, ::9].reshape(-1, 3), axis=0).astype(np.uint8)
    pixels[missing] = paper
    return pixels


def _grid(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Add a squared paper grid."""
    step = int(rng.uniform(8, 60) * max(1.0, max(pixels.shape[:2]) / 1300.0))
    colour = rng.uniform(150, 235, 3)
    lines = np.full(pixels.shape, 255, np.uint8)
    width = 1 + int(step > 30)
    for k in range(width):
        lines[k::step] = colour
        lines[:, k::step] = colour
    if rng.random() < 0.4:
        for k in range(width + 1):
            lines[k :: 5 * step] = 0.8 * colour
            lines[:, k :: 5 * step] = 0.8 * colour
    is_dark = float(pixels[::7, ::7].mean()) < 110.0
    return np.maximum(pixels, 255 - lines) if is_dark else np.minimum(pixels, lines)


def _watermark(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Add a pale rotated text, once or repeated."""
    height, width = pixels.shape[:2]
    side = int(np.hypot(height, width))
    layer = _sketch(np.zeros((side // 2, side // 2, 3), np.uint8), rng)
    word = str(rng.choice(['PREVIEW', 'sample', 'DRAFT', 'Entwurf', 'COPY', 'www.plans.example']))
    size = layer.pick(0.02, 0.12) * side / 2
    if layer.chance(0.5):
        layer.text(word, side / 4, side / 4, size, (255,) * 3, is_centred=True)
    else:
        for y in np.arange(0, side / 2, 4 * size):
            for x in np.arange(0, side / 2, 1.2 * size * len(word)):
                layer.text(word, float(x), float(y), size, (255,) * 3)
    angle = float(rng.uniform(-60, 60))
    M = cv2.getRotationMatrix2D((side / 4, side / 4), angle, 2.0)
    M[:, 2] += (width / 2 - side / 4, height / 2 - side / 4)
    mask = cv2.warpAffine(layer.pixels[..., 0], M, (width, height))
    share = mask[..., None].astype(np.float32) / 255.0 * np.float32(rng.uniform(0.1, 0.45))
    colour = rng.uniform(80, 220, 3).astype(np.float32)
    return np.asarray(pixels + share * (colour - pixels), np.float32).astype(np.uint8)


def _stain(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Add coffee stains."""
    height, width = pixels.shape[:2]
    layer = np.zeros((height, width), np.uint8)
    for _ in range(int(rng.integers(1, 4))):
        at = (int(rng.integers(width)), int(rng.integers(height)))
        radius = int(rng.uniform(0.04, 0.16) * max(height, width))
        cv2.circle(layer, at, radius, int(rng.integers(20, 90)), -1)
        cv2.circle(layer, at, radius, int(rng.integers(80, 170)), max(2, radius // 12))
    soft = cv2.GaussianBlur(layer, (0, 0), 2.0)
    share = soft.astype(np.float32)[..., None] / 255.0
    brown = np.array([150, 110, 70], np.float32) / 255.0
    return (pixels * (1.0 - share * (1.0 - brown))).astype(np.uint8)


def _holes(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Add punch holes at the left edge."""
    height, width = pixels.shape[:2]
    radius, tone = int(0.006 * max(height, width)) + 2, int(rng.integers(0, 200))
    for y in np.linspace(0.15, 0.85, int(rng.integers(2, 5))) * height:
        at = (int(0.02 * width) + radius, int(y))
        cv2.circle(pixels, at, radius, (tone,) * 3, -1, cv2.LINE_AA)
    return pixels


def _highlighter(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Add strokes of a highlighter."""
    height, width = pixels.shape[:2]
    layer = np.full((height, width, 3), 255, np.uint8)
    for _ in range(int(rng.integers(1, 6))):
        colour = tuple(rng.permutation([255, int(rng.integers(190, 256)), 110]).tolist())
        start = rng.uniform((0, 0), (width, height))
        steps = rng.normal(0, 0.05 * max(height, width), (int(rng.integers(2, 7)), 2))
        line = np.rint(start + np.cumsum(steps, axis=0)).astype(np.int32)
        pen = int(rng.uniform(0.005, 0.025) * max(height, width)) + 2
        cv2.polylines(layer, [line], rng.random() < 0.3, colour, pen, cv2.LINE_AA)
    return np.asarray(cv2.multiply(pixels, layer, scale=1.0 / 255.0), np.uint8)


def _stamp_over(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Add stamps or dates over the drawing."""
    s = _sketch(pixels, rng)
    width, height = s.size
    for _ in range(int(rng.integers(1, 3))):
        x, y = s.pick(0.1, 0.9) * width, s.pick(0.1, 0.9) * height
        size, colour = s.unit * s.pick(10, 40), s.colour(0, 220)
        word = str(rng.choice(['APPROVED', 'RECEIVED', '12 MAR 1987', 'VOID', 'KOPIE', 'SOLD']))
        length = s.text(word, x, y, size, colour)
        pad = int(0.4 * size)
        if s.chance(0.7):
            rect = (int(x) - pad, int(y) - pad, int(x + length) + pad, int(y + 1.4 * size) + pad)
            s.box(rect, None, colour, 2.5)
    return s.pixels


def _yellowed(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Darken and yellow the paper unevenly."""
    shape = (pixels.shape[0], pixels.shape[1])
    age = smooth_noise(rng, shape, int(rng.integers(3, 12)))[..., None]
    brown = np.array([0.92, 0.84, 0.62], np.float32)
    deep = np.float32(rng.uniform(0.5, 1.0))
    return (pixels * (1.0 - deep * (0.4 + 0.6 * age) * (1.0 - brown))).astype(np.uint8)


def _wobble(pixels: Pixels, rng: np.random.Generator, most_px: float) -> Pixels:
    """Displace lines by a smooth random field of at most ``most_px``, as if hand-drawn."""
    shape = (pixels.shape[0], pixels.shape[1])
    y, x = np.mgrid[: shape[0], : shape[1]].astype(np.float32)
    cells = int(rng.integers(12, 60))
    far = np.float32(most_px * rng.uniform(0.5, 1.0))
    x += far * (2.0 * smooth_noise(rng, shape, cells) - 1.0)
    y += far * (2.0 * smooth_noise(rng, shape, cells) - 1.0)
    return np.asarray(
        cv2.remap(pixels, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.uint8
    )


def _shrunk(pixels: Pixels, rng: np.random.Generator) -> tuple[Pixels, Array]:
    height, width = pixels.shape[:2]
    low, high = np.log(THUMBNAIL_PX)
    f = float(np.exp(rng.uniform(low, high))) / max(height, width)
    f = min(1.0, max(f, _LEAST_PX / min(height, width)))
    size = (round(f * width), round(f * height))
    style = cv2.INTER_AREA if rng.random() < 0.75 else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(pixels, size, interpolation=style), np.uint8), scaling(
        size[0] / width, size[1] / height
    )


def scaling(across: float, down: float) -> Array:
    """Return the map (3, 3) of pixel centres for resizing a picture."""
    return np.array(
        [[across, 0, (across - 1.0) / 2.0], [0, down, (down - 1.0) / 2.0], [0, 0, 1.0]]
    )


def _turned(
    pixels: Pixels, rng: np.random.Generator, style: SurroundStyle
) -> tuple[Pixels, Array]:
    """Rotate or skew the picture, with a border in the paper's or another colour."""
    height, width = pixels.shape[:2]
    angle = float(rng.uniform(-np.pi, np.pi)) if rng.random() < 0.5 else rng.normal(0.0, 0.12)
    angle *= 'turn' in style.effects
    c, s = np.cos(angle), np.sin(angle)
    A = np.array([[c, -s], [s, c]])
    if 'skew' in style.effects:
        A = A @ np.array([[1.0, rng.uniform(-0.2, 0.2)], [0.0, rng.uniform(0.85, 1.15)]])
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]]) - 0.5
    there = corners @ A.T
    low, high = there.min(axis=0), there.max(axis=0)
    f = min(1.0, 3500.0 / float((high - low).max()))
    M = np.column_stack([f * A, -f * low - 0.5])
    columns, rows = np.maximum(np.ceil(f * (high - low)), 2).astype(int).tolist()
    border = np.median(pixels[[0, -1]].reshape(-1, 3), axis=0).tolist()
    if rng.random() < 0.3:
        border = rng.uniform(0, 256, 3).tolist()
    moved = cv2.warpAffine(
        pixels, M, (columns, rows), flags=cv2.INTER_LINEAR, borderValue=tuple(border)
    )
    return np.asarray(moved, np.uint8), np.vstack([M, [0.0, 0.0, 1.0]])


def _halftone(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Add a halftone screen to all but white pixels."""
    height, width = pixels.shape[:2]
    y, x = np.mgrid[:height, :width].astype(np.float32)
    pitch, angle = rng.uniform(2.5, 5.0), rng.uniform(0, np.pi)
    u = (np.cos(angle) * x + np.sin(angle) * y) * np.float32(2 * np.pi / pitch)
    v = (np.cos(angle) * y - np.sin(angle) * x) * np.float32(2 * np.pi / pitch)
    screen = (np.cos(u) + np.cos(v)) * np.float32(rng.uniform(15, 45))
    shown = np.clip(pixels + screen[..., None] * (pixels < 250), 0, 255)
    return np.asarray(shown.astype(np.uint8))


def _moire(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Add moire stripes, as in a photo of a screen."""
    height, width = pixels.shape[:2]
    y, x = np.mgrid[:height, :width].astype(np.float32)
    waves: NDArray[np.float32] = np.zeros((height, width), np.float32)
    for _ in range(2):
        angle, pitch = rng.uniform(0, np.pi), rng.uniform(2.3, 30.0)
        phase = (np.cos(angle) * x + np.sin(angle) * y) * np.float32(2 * np.pi / pitch)
        waves += np.cos(phase) * np.float32(rng.uniform(2, 12))
    return np.asarray(np.clip(pixels + waves[..., None], 0, 255).astype(np.uint8))


def _blocks(pixels: Pixels, rng: np.random.Generator) -> Pixels:
    """Apply strong JPEG compression once or twice."""
    for _ in range(int(rng.integers(1, 3))):
        quality = int(rng.integers(10, 60))
        _, packed = cv2.imencode('.jpg', pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])
        pixels = np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR), np.uint8)
    return pixels


Effect = Callable[[Pixels, np.random.Generator], Pixels]

_MARKS: dict[str, Effect] = {
    'broken ink': _broken,
    'faint': _faint,
    'grid': _grid,
    'highlighter': _highlighter,
    'stamp over': _stamp_over,
    'tint': _tint,
    'yellowed': _yellowed,
    'watermark': _watermark,
    'stain': _stain,
    'holes': _holes,
}
_TAKEN: dict[str, Effect] = {'halftone': _halftone, 'moire': _moire, 'blocks': _blocks}
