# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Training drawings of the parser with per-pixel truth, generated on demand."""

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
"""Numerical: first seed of training sheets; those of benchmarks are smaller."""

MOST_BUILDING_PX = 1800
"""Longest side of a building in samples, as in the parser's last pass. Chosen."""

# Chosen, not measured:
_SHARES = {
    SheetKind.VARIED: 0.46, SheetKind.OFFICE: 0.12, SheetKind.SCAN: 0.10,
    SheetKind.BROCHURE: 0.09, SheetKind.PHONE: 0.06, SheetKind.CLEAN: 0.08,
}  # fmt: skip
_SPECIAL_SHARE = 0.4  # share of sheets of other kinds with special buildings, mostly halls
_GROUND_SHARE = 0.08  # share of sheets with a uniform background around their buildings,
_WALLS_SHARE = 0.6  # share of these with the colour of the walls, e.g. white rooms on solid black
_REAL_SHARE = 0.03  # share of real floorplans; the remaining samples show no floorplan
_SPECIAL_SEED, _GROUND_SEED = 7, 8  # numerical: independent of all else on a sheet
_REAL_PIXEL_M = 0.05  # given
_WIDEST_WALL_PX = 13  # of the real plans, whose pixels are 0.05 m
_FACE_PX = 7  # twice the depth of a wall that has no visible other side


@dataclass(frozen=True, eq=False)
class Sample:
    """
    Drawing with its truth.

    ``pixels (H, W, 3)``, their ``classes (H, W)``, ``overlays (H, W)`` with a bit each for text
    and furniture, and the pixel size [m], NaN without a building.
    """

    pixels: Pixels
    classes: Classes
    overlays: NDArray[np.uint8]
    pixel_m: float

    @cached_property
    def building_px(self) -> int:
        """Longer side of the building or buildings."""
        rows, cols = (np.flatnonzero((self.classes != OUTSIDE).any(axis=k)) for k in (1, 0))
        return int(max(np.ptp(rows), np.ptp(cols)) + 1) if rows.size else max(self.classes.shape)

    @cached_property
    def wall_px(self) -> float:
        """Mean thickness of walls."""
        return wall_cells(self.classes == WALL)


def samples(
    rng: np.random.Generator, first_seed: int, step: int, real: list[Sample]
) -> Iterator[Sample]:
    """
    Yield an infinite stream of samples.

    The seeds of sheets are ``first_seed``, ``first_seed + step`` and so on, so that processes with
    different first seeds draw different sheets.
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
    """Generate a sheet whose building is at most :data:`MOST_BUILDING_PX` long."""
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
        pixels = _on_uniform_background(pixels, classes, rng)
    return Sample(pixels, classes, overlays, sheet.resolution_m() / factor)


def _on_uniform_background(pixels: Pixels, classes: Classes, rng: np.random.Generator) -> Pixels:
    """Return a drawing with a uniform background, mostly in the colour of its walls."""
    is_wall = classes == WALL
    tone = rng.integers(0, 256, 3)
    if is_wall.any() and rng.random() < _WALLS_SHARE:
        tone = np.median(pixels[is_wall], axis=0)
    shown = pixels.copy()
    faces = is_wall & grown_by(classes == OUTSIDE, square(3))  # antialiased with the background
    shown[(classes == OUTSIDE) | faces] = tone
    return shown


def blank_sample(pixels: Pixels) -> Sample:
    """Return the sample of an image without a building."""
    none = np.zeros(pixels.shape[:2], np.uint8)
    return Sample(pixels, none, none, float('nan'))


def _on_white(pixels: Pixels) -> Pixels:
    """Return colours (H, W, 3); transparent pixels are blended with white."""
    if pixels.shape[2] == 3:
        return pixels
    opacity = pixels[..., 3:].astype(np.float32) / 255.0
    return np.asarray(np.rint(pixels[..., :3] * opacity + 255.0 * (1.0 - opacity)), np.uint8)


def real_samples(data: Path) -> list[Sample]:
    """
    Return the real floorplans of the development split in ``data``, bare and furnished.

    Labelled rooms are floor, and so are bright areas between them (doorways). Other areas that are
    narrow or next to floor are walls.
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
    """Return the classes of a clean plan whose outside is dark or separated by walls."""
    bright = bare.min(axis=2) >= FREE_GREY
    pieces, stats = pieces_of(bright, connectivity=4)
    roomy = np.zeros(len(stats), np.bool_)
    roomy[np.unique(pieces[labels > 0])] = True
    roomy[0] = False
    floor = roomy[pieces]
    wide = opened_by(~floor, square(_WIDEST_WALL_PX), is_beyond=True)
    is_wall = ~floor & (~wide | grown_by(floor, square(_FACE_PX)))
    return np.select([floor, is_wall], [FLOOR, WALL], OUTSIDE).astype(np.uint8)
