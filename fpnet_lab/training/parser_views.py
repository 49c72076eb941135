# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Two views of a drawing, one per pass of the parser: the whole sheet, and the building in detail.

All shares and ranges are numerical: they cover the variety of real drawings.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.io.pixel_classes import FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_core.raster.windows import window_of
from fpnet_lab.sim.sheets.classes import Classes
from fpnet_lab.training.parser_samples import Pixels, Sample

Array = NDArray[np.float64]

# Chosen, not measured:
_SHEET_PX = (340.0, 900.0)  # longer side of a sheet in the first view
_WHOLE, _WHOLE_SHARE = 0.5, (0.8, 1.0)  # share of views of a whole sheet; its relative size
_BUILDING_PX = (350.0, 1400.0)  # longer side of a building in the second view
_WALL_PX = (2.5, 8.0)  # mean thickness of walls, if the second view is sized by them
_BY_WALLS = 0.6  # share of second views that are sized by walls, the others by the building
_MOST_ENLARGED = 1.5
_FLIPPED = 0.5  # share of mirrored samples
_IN_BUILDING = 0.85  # share of second views that are centred in the building
_TURNED, _TURN_RAD, _ANY_TURN = 0.3, 0.07, 0.08
_PRESSED, _QUALITY = 0.2, (25, 90)  # share of views with JPEG artefacts, and JPEG quality
_SOLID_LEVEL = 56  # of 255: least wall share of a pixel that stays wall in a smaller image


@dataclass(frozen=True, eq=False)
class SampleView:
    """``pixels (S, S, 3)``, ``answers (S, S)`` and the true pixel size [m], or NaN."""

    pixels: Pixels
    answers: NDArray[np.uint8]
    pixel_m: float


def two_views(
    sample: Sample, side_px: int, rng: np.random.Generator
) -> tuple[SampleView, SampleView, Array]:
    """
    Return the first and the second view of a sample.

    The third value is the affine map (2, 3) from the second view's pixels to the first one's.
    Answers hold the class in the lower three bits and overlays in the next two.
    """
    quarters, is_flipped = int(rng.integers(4)), rng.random() < _FLIPPED
    turn = float(rng.uniform(-_TURN_RAD, _TURN_RAD)) if rng.random() < _TURNED else 0.0
    turn = float(rng.uniform(-np.pi, np.pi)) if rng.random() < _ANY_TURN else turn
    turn += quarters * np.pi / 2.0
    height, width = sample.classes.shape
    wanted = float(np.exp(rng.uniform(*np.log(_SHEET_PX))))
    if rng.random() < _WHOLE:
        wanted = side_px * float(rng.uniform(*_WHOLE_SHARE))
    factor = min(wanted / max(height, width), _MOST_ENLARGED)
    middle = np.array([width - 1, height - 1]) / 2.0
    A_first = _placed(
        middle, factor, turn, is_flipped, side_px, rng, factor * np.array([width, height])
    )
    A_second = _placed(
        _middle(sample, rng), _second_factor(sample, rng), turn, is_flipped, side_px, rng, None
    )
    first = _view(sample, A_first, factor, side_px, rng)
    second = _view(sample, A_second, abs(np.linalg.det(A_second[:, :2])) ** 0.5, side_px, rng)
    return first, second, _between(A_first, A_second)


def _placed(
    middle: Array,
    factor: float,
    turn: float,
    is_flipped: bool,
    side_px: int,
    rng: np.random.Generator,
    size: Array | None,
) -> Array:
    """Return the map (2, 3) from a sample's pixels to a view with ``middle`` near its centre."""
    c, s = np.cos(turn), np.sin(turn)
    linear = factor * np.array([[c, -s], [s, c]]) @ np.diag([-1.0 if is_flipped else 1.0, 1.0])
    at = np.full(2, (side_px - 1) / 2.0)
    if size is not None:  # random position of the sheet in the view, or of the view on the sheet
        spare = np.abs(side_px - np.abs([[c, -s], [s, c]]) @ size) / 2.0
        at = at + rng.uniform(-1.0, 1.0, 2) * spare
    return np.asarray(np.column_stack([linear, at - linear @ middle]))


def _second_factor(sample: Sample, rng: np.random.Generator) -> float:
    """Return a random scale of the second view."""
    low, high = np.array(_BUILDING_PX) / sample.building_px
    building = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    thickness = float(np.exp(rng.uniform(*np.log(_WALL_PX))))
    if rng.random() > _BY_WALLS or sample.wall_px <= 1.0:
        return min(building, _MOST_ENLARGED)
    return float(min(max(thickness / sample.wall_px, low), high, _MOST_ENLARGED))


def _middle(sample: Sample, rng: np.random.Generator) -> Array:
    """Return a random position (x, y), mostly in the building."""
    height, width = sample.classes.shape
    if rng.random() < _IN_BUILDING and (window := window_of(sample.classes != OUTSIDE)):
        y, x = (rng.integers(part.start, part.stop) for part in window)
        return np.array([float(x), float(y)])
    return np.array([float(rng.integers(width)), float(rng.integers(height))])


def _between(A_first: Array, A_second: Array) -> Array:
    inverse = np.linalg.inv(np.vstack([A_second, [0.0, 0.0, 1.0]]))
    return np.asarray(A_first @ inverse)


def _view(
    sample: Sample, A: Array, factor: float, side_px: int, rng: np.random.Generator
) -> SampleView:
    """Return a view: first resampled to about its size, then moved and rotated."""
    shrink = min(1.0, factor)
    height, width = sample.classes.shape
    size = (max(1, round(shrink * width)), max(1, round(shrink * height)))
    pixels, answers = shrunk(sample, size)
    per_pixel = np.array([size[0] / width, size[1] / height])
    back = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.0, 0.0, 1.0]])
    there = np.linalg.inv(back)
    S = there @ np.diag([*per_pixel, 1.0]) @ back  # from a sample's pixels to the smaller image's
    A = A @ np.linalg.inv(S)
    square = (side_px, side_px)
    shown = cv2.warpAffine(pixels, A, square, borderMode=cv2.BORDER_REPLICATE)
    true = cv2.warpAffine(answers, A, square, flags=cv2.INTER_NEAREST, borderValue=OUTSIDE)
    if rng.random() < _PRESSED:
        quality = int(rng.integers(*_QUALITY))
        _, data = cv2.imencode('.jpg', shown, [cv2.IMWRITE_JPEG_QUALITY, quality])
        shown = np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR))
    return SampleView(
        np.asarray(shown, np.uint8), np.asarray(true, np.uint8), sample.pixel_m / factor
    )


def shrunk(sample: Sample, size: tuple[int, int]) -> tuple[Pixels, Classes]:
    """Return pixels and answers of another size; walls get thinner, but stay closed."""
    answers = np.asarray(sample.classes | (sample.overlays << 3), np.uint8)
    if size[0] >= sample.classes.shape[1]:
        return sample.pixels, answers
    pixels = cv2.resize(sample.pixels, size, interpolation=cv2.INTER_AREA)
    kept = np.where(sample.classes == WALL, FLOOR, answers)  # walls are set by their share below
    found = np.asarray(cv2.resize(kept, size, interpolation=cv2.INTER_NEAREST), np.uint8)
    for value in (WINDOW, WALL):
        mask = (sample.classes == value).astype(np.uint8) * 255
        is_it = cv2.resize(mask, size, interpolation=cv2.INTER_AREA) > _SOLID_LEVEL
        found[is_it] = (found[is_it] & 0b11000) | value
    return np.asarray(pixels, np.uint8), found
