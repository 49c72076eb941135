# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings with the truth of every pixel, from which the parser learns; made when needed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.formats.images import open_image
from fpnet_core.drawings.pictures.thickness import wall_cells
from fpnet_core.io.pixel_classes import FLOOR, OUTSIDE, WALL
from fpnet_core.raster.morphology import grown_by, opened_by, square
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.raster.pixels import shrinking
from fpnet_lab.sim.plans.special import generate_special_plan
from fpnet_lab.sim.population.floors import FREE_GREY, TUNE_FLOORS, read_labels
from fpnet_lab.sim.sheets import SheetKind, draw_sheet
from fpnet_lab.sim.sheets.classes import Classes, sheet_classes, sheet_overlays
from fpnet_lab.sim.sheets.negatives import draw_negative

Pixels = NDArray[np.uint8]

FIRST_SEED = 4_000_000
"""Numerical: of sheets to learn from; those of benchmarks are below, see bench drawings."""

MOST_BUILDING_PX = 1800
"""The longer side of a building in samples: as large as the parser looks at one. Chosen."""

# Chosen, not measured:
_SHARES = {
    SheetKind.VARIED: 0.46, SheetKind.OFFICE: 0.12, SheetKind.SCAN: 0.10,
    SheetKind.BROCHURE: 0.09, SheetKind.PHONE: 0.06, SheetKind.CLEAN: 0.08,
}  # fmt: skip
_SPECIAL_SHARE = 0.4  # of sheets of other kinds show buildings as varied ones do, halls mostly
_GROUND_SHARE = 0.08  # of sheets show nothing but paper of one tone around their buildings,
_WALLS_SHARE = 0.6  # of these the tone of the walls, as a plan of white rooms on solid black
_REAL_SHARE = 0.03  # of samples are real floorplans; what is left shows no floorplan
_SPECIAL_SEED, _GROUND_SEED = 7, 8  # numerical: such choices change nothing else of a sheet
_REAL_PIXEL_M = 0.05  # given
_WIDEST_WALL_PX = 13  # of the real plans, whose pixels are 0.05 m
_FACE_PX = 7  # twice as deep as a wall is seen where there is no other side to it


@dataclass(frozen=True, eq=False)
class Sample:
    """
    A drawing and its truth.

    ``pixels (H, W, 3)``, their ``classes (H, W)``, ``overlays (H, W)`` with a bit each for text
    and furniture, and the edge of a pixel [m], NaN where it shows no building.
    """

    pixels: Pixels
    classes: Classes
    overlays: NDArray[np.uint8]
    pixel_m: float

    @cached_property
    def building_px(self) -> int:
        """The longer side of the building or buildings."""
        rows, cols = (np.flatnonzero((self.classes != OUTSIDE).any(axis=k)) for k in (1, 0))
        return int(max(np.ptp(rows), np.ptp(cols)) + 1) if rows.size else max(self.classes.shape)

    @cached_property
    def wall_px(self) -> float:
        """The mean thickness of walls."""
        return wall_cells(self.classes == WALL)


def samples(
    rng: np.random.Generator, first_seed: int, step: int, real: list[Sample]
) -> Iterator[Sample]:
    """
    Yield samples without end.

    Seeds of sheets are ``first_seed``, ``first_seed + step`` and so on, so that processes with
    other first seeds draw other sheets.
    """
    seed = first_seed
    kinds, chance = list(_SHARES), np.array(list(_SHARES.values()))
    while True:
        pick = rng.random()
        if pick < chance.sum():
            kind = kinds[int(np.searchsorted(np.cumsum(chance), pick, side='right'))]
            yield sheet_sample(seed, kind)
        elif pick < chance.sum() + _REAL_SHARE and real:
            yield real[int(rng.integers(len(real)))]
        else:
            yield blank_sample(draw_negative(seed))
        seed += step


def sheet_sample(seed: int, kind: SheetKind) -> Sample:
    """Draw a sheet of a kind, its building at most :data:`MOST_BUILDING_PX` long."""
    rng = np.random.default_rng([seed, _SPECIAL_SEED])
    is_special = kind is not SheetKind.VARIED and rng.random() < _SPECIAL_SHARE
    sheet = draw_sheet(seed, kind, generate_special_plan(rng) if is_special else None)
    extents = [storey.on_page.extent for storey in sheet.storeys]
    long_m = max(float(np.ptp(extent, axis=0).max()) for extent in extents)
    factor = min(1.0, MOST_BUILDING_PX * sheet.resolution_m() / long_m)
    pixels = _on_white(sheet.pixels)
    size = [max(1, round(factor * side)) for side in pixels.shape[1::-1]]
    if factor < 1.0:
        pixels = np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)
    H = shrinking((size[0] / sheet.pixels.shape[1], size[1] / sheet.pixels.shape[0]))
    shape = (size[1], size[0])
    classes, overlays = sheet_classes(sheet, H, shape), sheet_overlays(sheet, H, shape)
    rng = np.random.default_rng([seed, _GROUND_SEED])
    if rng.random() < _GROUND_SHARE:
        pixels = _on_one_tone(pixels, classes, rng)
    return Sample(pixels, classes, overlays, sheet.resolution_m() / factor)


def _on_one_tone(pixels: Pixels, classes: Classes, rng: np.random.Generator) -> Pixels:
    """Return a drawing around whose buildings all is of one tone, that of walls mostly."""
    is_wall = classes == WALL
    tone = rng.integers(0, 256, 3)
    if is_wall.any() and rng.random() < _WALLS_SHARE:
        tone = np.median(pixels[is_wall], axis=0)
    shown = pixels.copy()
    faces = is_wall & grown_by(classes == OUTSIDE, square(3))  # which the paper shines into
    shown[(classes == OUTSIDE) | faces] = tone
    return shown


def blank_sample(pixels: Pixels) -> Sample:
    """Return a picture that shows no building."""
    none = np.zeros(pixels.shape[:2], np.uint8)
    return Sample(pixels, none, none, float('nan'))


def _on_white(pixels: Pixels) -> Pixels:
    """Return colours (H, W, 3), of transparent pixels those of white paper."""
    if pixels.shape[2] == 3:
        return pixels
    opacity = pixels[..., 3:].astype(np.float32) / 255.0
    return np.asarray(np.rint(pixels[..., :3] * opacity + 255.0 * (1.0 - opacity)), np.uint8)


def real_samples(data: Path) -> list[Sample]:
    """
    Return the real floorplans of the development split in ``data``, bare and furnished.

    What people have labelled as a room is floor, and so is what is bright between: doorways.
    What is not, and is narrow or beside it, is wall.
    """
    folder = data / 'bormann'
    found = []
    for name in TUNE_FLOORS:
        bare = open_image(folder / 'floorplan' / f'{name}.png').pixels
        labels = read_labels(folder / 'room_labels' / f'{name}.png')[::-1]
        classes = _real_classes(bare, labels)
        none = np.zeros_like(classes)
        for path in (
            folder / 'floorplan' / f'{name}.png',
            *sorted((folder / 'furnished').glob(f'{name}_*.png')),
        ):
            found.append(Sample(open_image(path).pixels, classes, none, _REAL_PIXEL_M))
    return found


def _real_classes(bare: Pixels, labels: NDArray[np.int32]) -> Classes:
    """Return the classes of a clean plan whose outside is not bright or is cut off by walls."""
    bright = bare.min(axis=2) >= FREE_GREY
    pieces, stats = pieces_of(bright, connectivity=4)
    roomy = np.zeros(len(stats), np.bool_)
    roomy[np.unique(pieces[labels > 0])] = True
    roomy[0] = False
    floor = roomy[pieces]
    wide = opened_by(~floor, square(_WIDEST_WALL_PX), is_beyond=True)
    is_wall = ~floor & (~wide | grown_by(floor, square(_FACE_PX)))
    return np.select([floor, is_wall], [FLOOR, WALL], OUTSIDE).astype(np.uint8)
