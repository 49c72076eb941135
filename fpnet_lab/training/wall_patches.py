# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Square parts of drawings, varied in size, place and tone beyond what the simulator draws.

All shares and ranges are numerical: they span what people's drawings are like.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.io.pixel_classes import FLOOR, OUTSIDE
from fpnet_core.raster.windows import window_of
from fpnet_lab.sim.sheets.classes import Classes
from fpnet_lab.training.wall_samples import Pixels, WallSample, read_sample, resized

Shown = NDArray[np.float32]

# Chosen, not measured:
_BUILDING_PX = (400.0, 1300.0)  # the longer side of a building as the network may see it
_WALL_PX = (2.5, 7.0)  # the mean thickness of walls, where the finer look is trained
_BY_WALLS = 0.6  # of patches are sized by their walls, the others by the building
_MOST_ENLARGED = 1.3
_IN_BUILDING = 0.75  # of patches have their middle in the building
_TURNED, _TURN_RAD, _ANY_TURN = 0.3, 0.07, 0.08
_PER_PICTURE = 16  # numerical: patches that are cut from a picture before another one is read
_POOL = 32  # numerical: pictures to choose from
_KIND_WEIGHTS = {
    'office': 3.0, 'scan': 2.6, 'brochure': 2.0, 'phone': 1.6, 'clean': 1.0, 'real': 0.5,
}  # fmt: skip
"""How often a picture is of a kind, however many of it there are. Chosen."""

# Chosen, not measured:
_SHADE_CELLS = 4
_SCRIBBLES = 14


def patches(
    stems: Sequence[Path], side_px: int, rng: np.random.Generator
) -> Iterator[tuple[Pixels, Classes]]:
    """Yield varied parts (S, S, 3) of samples without end, and their classes (S, S)."""
    kinds = [stem.name.partition('-')[0] for stem in stems]
    weight = np.array([_KIND_WEIGHTS[kind] / kinds.count(kind) for kind in kinds])
    chance = weight / weight.sum()
    pool: list[WallSample] = []
    while True:
        if len(pool) < _POOL or rng.random() < 1.0 / _PER_PICTURE:
            sample = read_sample(stems[int(rng.choice(len(stems), p=chance))])
            pool = [*pool[-(_POOL - 1) :], sample]
        yield patch(pool[int(rng.integers(len(pool)))], side_px, rng)


def patch(sample: WallSample, side_px: int, rng: np.random.Generator) -> tuple[Pixels, Classes]:
    """Return one varied part (S, S, 3) of a sample and its classes (S, S)."""
    pixels, classes = _placed(sample, side_px, rng)
    shown = _scribbled(pixels, classes, rng).astype(np.float32)
    for change, share in _CHANGES:
        if rng.random() < share:
            shown = change(shown, rng)
    return np.clip(np.rint(shown), 0, 255).astype(np.uint8), classes


def _placed(sample: WallSample, side_px: int, rng: np.random.Generator) -> tuple[Pixels, Classes]:
    """Return a part at some size, turned and flipped."""
    factor = _drawn_factor(sample, rng)
    turn = float(rng.uniform(-_TURN_RAD, _TURN_RAD)) if rng.random() < _TURNED else 0.0
    turn = float(rng.uniform(-np.pi, np.pi)) if rng.random() < _ANY_TURN else turn
    quarters, is_flipped = int(rng.integers(4)), rng.random() < 0.5
    part, labels = _square(sample, _middle(sample, rng), side_px, factor, turn)
    part, labels = np.rot90(part, quarters), np.rot90(labels, quarters)
    if is_flipped:
        part, labels = part[:, ::-1], labels[:, ::-1]
    return np.ascontiguousarray(part, np.uint8), np.ascontiguousarray(labels, np.uint8)


def _drawn_factor(sample: WallSample, rng: np.random.Generator) -> float:
    """Draw how much larger a patch shows a drawing: as one look or the other would."""
    low, high = np.array(_BUILDING_PX) / sample.building_px
    building = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    thickness = float(np.exp(rng.uniform(*np.log(_WALL_PX))))
    if rng.random() > _BY_WALLS or sample.wall_px == 0.0:
        return min(building, _MOST_ENLARGED)
    return float(min(max(thickness / sample.wall_px, low), high, _MOST_ENLARGED))


def _square(
    sample: WallSample, middle: tuple[int, int], side_px: int, factor: float, turn: float
) -> tuple[Pixels, Classes]:
    """Return the square (S, S, 3) around a place, resized and turned [rad], and its classes."""
    widened = abs(np.cos(turn)) + abs(np.sin(turn))
    reach = int(np.ceil(0.5 * widened * side_px / factor)) + 2
    size = max(side_px, round(2 * reach * factor))
    part = resized(_cut(sample, *middle, reach), (size, size))
    centre = (size - 1) / 2.0
    A = np.asarray(cv2.getRotationMatrix2D((centre, centre), float(np.degrees(turn)), 1.0), float)
    A[:, 2] += (side_px - 1) / 2.0 - centre
    square = (side_px, side_px)
    shown = cv2.warpAffine(part.pixels, A, square, borderMode=cv2.BORDER_REPLICATE)
    true = cv2.warpAffine(part.classes, A, square, flags=cv2.INTER_NEAREST, borderValue=OUTSIDE)
    return np.asarray(shown, np.uint8), np.asarray(true, np.uint8)


def _middle(sample: WallSample, rng: np.random.Generator) -> tuple[int, int]:
    """Return a place (x, y), mostly in the building."""
    height, width = sample.classes.shape
    if rng.random() < _IN_BUILDING and (window := window_of(sample.classes != OUTSIDE)):
        y, x = (rng.integers(part.start, part.stop) for part in window)
        return int(x), int(y)
    return int(rng.integers(width)), int(rng.integers(height))


def _cut(sample: WallSample, x: int, y: int, reach: int) -> WallSample:
    """Return the square of twice ``reach`` around a place; beyond the picture its edge goes on."""
    height, width = sample.classes.shape
    box = (max(0, y - reach), min(height, y + reach), max(0, x - reach), min(width, x + reach))
    rows, cols = slice(*box[:2]), slice(*box[2:])
    margin = (box[0] - (y - reach), y + reach - box[1], box[2] - (x - reach), x + reach - box[3])
    pixels = cv2.copyMakeBorder(sample.pixels[rows, cols], *margin, cv2.BORDER_REPLICATE)
    classes = cv2.copyMakeBorder(
        sample.classes[rows, cols], *margin, cv2.BORDER_CONSTANT, value=OUTSIDE
    )
    return WallSample(np.asarray(pixels, np.uint8), np.asarray(classes, np.uint8))


def _scribbled(pixels: Pixels, classes: Classes, rng: np.random.Generator) -> Pixels:
    """Return the picture with small things on its floors: boxes, circles, strokes."""
    if rng.random() < 0.75:
        return pixels
    shown = pixels.copy()
    rows, cols = np.nonzero(classes == FLOOR)
    if not rows.size:
        return shown
    tone = rng.uniform(0.0, 0.7) * float(shown.max())
    for place in rng.integers(rows.size, size=int(rng.integers(1, _SCRIBBLES))).tolist():
        x, y = int(cols[place]), int(rows[place])
        w, h = (int(value) for value in rng.integers(2, 26, 2))
        colour = (tone, tone, tone)
        thick = -1 if rng.random() < 0.25 else 1
        if rng.random() < 0.6:
            cv2.rectangle(shown, (x - w, y - h), (x + w, y + h), colour, thick)
        else:
            cv2.ellipse(
                shown, (x, y), (w, h), 0.0, 0.0, float(rng.uniform(60, 360)), colour, thick
            )
    kept = classes != FLOOR  # they end at walls, as furniture does
    shown[kept] = pixels[kept]
    return shown


def _grey(shown: Shown, rng: np.random.Generator) -> Shown:
    del rng
    return np.repeat(shown.mean(axis=2, keepdims=True), 3, axis=2)


def _mixed(shown: Shown, rng: np.random.Generator) -> Shown:
    return shown[..., rng.permutation(3)]


def _tinted(shown: Shown, rng: np.random.Generator) -> Shown:
    return shown * rng.uniform(0.75, 1.0, 3).astype(np.float32)


def _curved(shown: Shown, rng: np.random.Generator) -> Shown:
    """Return other mid-tones, per channel a little differently."""
    power = np.exp(rng.normal(0.0, 0.45) + rng.normal(0.0, 0.1, 3)).astype(np.float32)
    return np.asarray(255.0 * (np.clip(shown, 0.0, 255.0) / 255.0) ** power, np.float32)


def _faded(shown: Shown, rng: np.random.Generator) -> Shown:
    """Return paler ink on darker paper, now and then hardly to be seen."""
    paper = rng.uniform(170.0, 255.0)
    ink = rng.uniform(0.0, 0.85 if rng.random() < 0.15 else 0.5) * paper
    return np.asarray(ink + shown * (paper - ink) / 255.0, np.float32)


def _shaded(shown: Shown, rng: np.random.Generator) -> Shown:
    coarse = rng.uniform(rng.uniform(0.45, 0.95), 1.0, (_SHADE_CELLS, _SHADE_CELLS))
    size = (shown.shape[1], shown.shape[0])
    light = cv2.resize(coarse.astype(np.float32), size, interpolation=cv2.INTER_LINEAR)
    return np.asarray(shown * light[..., None], np.float32)


def _blurred(shown: Shown, rng: np.random.Generator) -> Shown:
    sigma = float(rng.uniform(0.3, 1.2))
    return np.asarray(cv2.GaussianBlur(shown, (0, 0), sigma), np.float32)


def _noisy(shown: Shown, rng: np.random.Generator) -> Shown:
    channels = 1 if rng.random() < 0.5 else 3
    noise = rng.standard_normal((*shown.shape[:2], channels), np.float32)
    return np.asarray(shown + noise * np.float32(rng.uniform(1.0, 12.0)), np.float32)


def _pressed(shown: Shown, rng: np.random.Generator) -> Shown:
    """Return the picture as JPEG keeps it."""
    quality = int(rng.integers(25, 90))
    levels = np.clip(np.rint(shown), 0, 255).astype(np.uint8)
    _, data = cv2.imencode('.jpg', levels, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.float32)


def _copied(shown: Shown, rng: np.random.Generator) -> Shown:
    """Return it in black and white."""
    grey = shown.mean(axis=2, keepdims=True)
    edge = rng.uniform(0.5, 0.85) * float(np.quantile(grey, 0.9))
    return np.repeat(np.where(grey > edge, 255.0, 0.0).astype(np.float32), 3, axis=2)


def _inverted(shown: Shown, rng: np.random.Generator) -> Shown:
    del rng
    return np.asarray(255.0 - shown, np.float32)


# Chosen, not measured:
_CHANGES: tuple[tuple[Callable[[Shown, np.random.Generator], Shown], float], ...] = (
    (_grey, 0.15),
    (_mixed, 0.2),
    (_curved, 0.2),
    (_faded, 0.25),
    (_tinted, 0.15),
    (_shaded, 0.2),
    (_blurred, 0.2),
    (_noisy, 0.2),
    (_copied, 0.02),
    (_pressed, 0.2),
    (_inverted, 0.03),
)
