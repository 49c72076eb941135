# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawing on pixels: lines, areas, texts and free places, all in pixel units."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
import itertools
from pathlib import Path

import cv2
import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import ImageFont

Array = NDArray[np.float64]
Pixels = NDArray[np.uint8]
Rgb = tuple[int, int, int]
Rect = tuple[int, int, int, int]
"""Left, top, right and bottom [px]."""

_FONTS = ('DejaVuSans', 'DejaVuSerif', 'DejaVuSansMono', 'DejaVuSans-Bold', 'STIXGeneral')
_WORDS = str.split(
    'plan level floor area wall detail section see note all existing new concrete timber door '
    'window schedule type finish size height room office store hall kitchen bath stair revision '
    'date drawn checked scale north site lot street garden Grundriss Bestand Neubau Wohnen Bad '
    'Flur Maßstab Datum plano planta nivel cuarto the of and to be by for with not on'
)
_TRIES = 30  # numerical


@lru_cache(maxsize=256)
def _font(name: str, size: int) -> ImageFont.FreeTypeFont:
    path = Path(matplotlib.get_data_path()) / 'fonts' / 'ttf' / f'{name}.ttf'
    return ImageFont.truetype(str(path), size, layout_engine=ImageFont.Layout.BASIC)


@dataclass
class Sketch:
    """
    A drawing surface on a picture.

    Parameters
    ----------
    pixels : (H, W, 3), modified in place
    rng : random generator
    ink, paper : default colours
    unit : width of a fine line [px]
    taken : (H, W), True at occupied places
    """

    pixels: Pixels
    rng: np.random.Generator
    ink: Rgb = (0, 0, 0)
    paper: Rgb = (255, 255, 255)
    unit: float = 1.0
    taken: NDArray[np.bool_] | None = None
    font: str = field(default='')

    def __post_init__(self) -> None:
        self.font = self.font or str(self.rng.choice(_FONTS))

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [px]."""
        return self.pixels.shape[1], self.pixels.shape[0]

    @property
    def is_dark(self) -> bool:
        """Return whether the paper is darker than the ink."""
        return sum(self.paper) < sum(self.ink)

    def pick(self, low: float, high: float) -> float:
        """Sample a number uniformly."""
        return float(self.rng.uniform(low, high))

    def chance(self, share: float) -> bool:
        """Sample True with probability ``share``."""
        return bool(self.rng.random() < share)

    def width(self, pens: float = 1.0) -> int:
        """Return a line width in whole pixels."""
        return max(1, round(self.unit * pens))

    def colour(self, low: int = 0, high: int = 256) -> Rgb:
        """Sample a colour."""
        r, g, b = self.rng.integers(low, high, 3).tolist()
        return r, g, b

    def pale(self) -> Rgb:
        """Sample a colour close to the paper's colour."""
        share = self.pick(0.08, 0.4)
        other = self.colour()
        r, g, b = (round(p + share * (o - p)) for p, o in zip(self.paper, other, strict=True))
        return r, g, b

    def pen(self) -> Rgb:
        """Sample a line colour: mostly the ink, else a paler ink or any darker colour."""
        pick = self.rng.random()
        if pick < 0.6:
            return self.ink
        if pick < 0.8:
            share = self.pick(0.2, 0.65)
            r, g, b = (
                round(i + share * (p - i)) for i, p in zip(self.ink, self.paper, strict=True)
            )
            return r, g, b
        return self.colour(0, 180)

    def line(self, points: Array, colour: Rgb, pens: float = 1.0, is_closed: bool = False) -> None:
        """Draw a polyline (V, 2)."""
        if len(points) > 1:
            whole = np.rint(np.clip(points, -2e4, 2e4)).astype(np.int32)
            cv2.polylines(self.pixels, [whole], is_closed, colour, self.width(pens), cv2.LINE_AA)

    def dashed(self, points: Array, colour: Rgb, pens: float, dash_px: float) -> None:
        """Draw a dashed polyline (V, 2)."""
        for a, b in itertools.pairwise(points):
            length = float(np.linalg.norm(b - a))
            count = min(int(length / (2.0 * dash_px)) + 1, 400)
            for i in range(count):
                ends = np.array([i, i + 0.55]) / count
                self.line(a + ends[:, None] * (b - a), colour, pens)

    def fill(self, points: Array, colour: Rgb) -> None:
        """Fill a polygon (V, 2)."""
        whole = np.rint(np.clip(points, -2e4, 2e4)).astype(np.int32)
        cv2.fillPoly(self.pixels, [whole], colour, cv2.LINE_AA)

    def box(
        self, rect: Rect, fill: Rgb | None = None, edge: Rgb | None = None, pens: float = 1.0
    ) -> None:
        """Draw a rectangle."""
        left, top, right, bottom = rect
        if fill is not None:
            cv2.rectangle(self.pixels, (left, top), (right, bottom), fill, -1)
        if edge is not None:
            cv2.rectangle(self.pixels, (left, top), (right, bottom), edge, self.width(pens))

    def disc(
        self, x: float, y: float, radius: float, colour: Rgb, pens: float | None = 1.0
    ) -> None:
        """Draw a circle, filled if ``pens`` is None."""
        width = -1 if pens is None else self.width(pens)
        at = (round(x), round(y))
        cv2.circle(self.pixels, at, max(1, round(radius)), colour, width, cv2.LINE_AA)

    def text(
        self,
        text: str,
        x: float,
        y: float,
        height: float,
        colour: Rgb | None = None,
        *,
        is_centred: bool = False,
        is_upright: bool = False,
        most_px: float = 1e9,
    ) -> float:
        """Write text with its top left (or centre) at ``x, y``; return its length [px]."""
        size = max(5, round(height * 1.35))
        core = _font(self.font, size).getmask(text)
        if not core.size[0] or not core.size[1]:
            return 0.0
        mask = np.array(core, np.uint8).reshape(core.size[1], core.size[0])
        if mask.shape[1] > most_px >= 1.0:
            share = most_px / mask.shape[1]
            shape = (max(1, int(most_px)), max(1, round(mask.shape[0] * share)))
            mask = np.asarray(cv2.resize(mask, shape, interpolation=cv2.INTER_AREA), np.uint8)
        if is_upright:
            mask = np.ascontiguousarray(np.rot90(mask))
        rows, columns = mask.shape
        left, top = round(x), round(y)
        if is_centred:
            left, top = left - columns // 2, top - rows // 2
        self._blend(mask, left, top, colour or self.ink)
        return float(columns)

    def _blend(self, mask: Pixels, left: int, top: int, colour: Rgb) -> None:
        width, height = self.size
        a, b = max(left, 0), max(top, 0)
        c, d = min(left + mask.shape[1], width), min(top + mask.shape[0], height)
        if a >= c or b >= d:
            return
        part = self.pixels[b:d, a:c].astype(np.float32)
        share = mask[b - top : d - top, a - left : c - left, None].astype(np.float32) / 255.0
        part += share * (np.array(colour, np.float32) - part)
        self.pixels[b:d, a:c] = np.rint(part).astype(np.uint8)

    def words(self, count: int) -> str:
        """Sample words of a note."""
        return ' '.join(self.rng.choice(_WORDS, count).tolist())

    def free(self, wide: tuple[float, float], high: tuple[float, float]) -> Rect | None:
        """Reserve a free rectangle with sides within bounds [px]; return None if none is found."""
        width, height = self.size
        if self.taken is None:
            self.taken = np.zeros((height, width), np.bool_)
        for attempt in range(_TRIES):
            shrink = 1.0 - 0.6 * attempt / _TRIES
            w, h = (int(shrink * self.pick(*bounds)) for bounds in (wide, high))
            if w < 4 or h < 4 or w >= width - 2 or h >= height - 2:
                continue
            x, y = int(self.rng.integers(0, width - w)), int(self.rng.integers(0, height - h))
            if not self.taken[y : y + h : 3, x : x + w : 3].any():
                self.taken[y : y + h, x : x + w] = True
                return x, y, x + w, y + h
        return None


def blank(shape: tuple[int, int], colour: Rgb) -> Pixels:
    """Return pixels (H, W, 3) of one colour."""
    pixels = np.empty((*shape, 3), np.uint8)
    pixels[:] = colour
    return pixels


def smooth_noise(
    rng: np.random.Generator, shape: tuple[int, int], cells: int
) -> NDArray[np.float32]:
    """Return a smooth random field (H, W) from 0 to 1."""
    coarse = rng.random((cells, cells), np.float32)
    size = (shape[1], shape[0])
    grown = cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC)
    return np.asarray(np.clip(grown, 0.0, 1.0), np.float32)
