# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings with the class of every pixel, from which the network learns to read walls."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.formats.images import open_image
from fpnet_core.drawings.pictures.thickness import wall_cells
from fpnet_core.errors import FpnetError
from fpnet_core.io.pixel_classes import FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_core.raster.morphology import grown_by, opened_by, square
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.raster.pixels import shrinking
from fpnet_lab.pool import each_done
from fpnet_lab.sim.population.floors import FREE_GREY, TUNE_FLOORS, read_labels
from fpnet_lab.sim.sheets import SheetKind, draw_sheet
from fpnet_lab.sim.sheets.classes import Classes, sheet_classes

Pixels = NDArray[np.uint8]

FIRST_SEEDS = {'train': 2_000_000, 'held': 3_000_000}
"""
Numerical: of sheets to learn from and to measure on; the benchmark's are below, see bench
drawings.
"""

MOST_BUILDING_PX = 1800
"""The longer side of a building in kept pictures: as large as the reader looks at one. Chosen."""

_QUALITY = 94  # numerical: of kept pictures of paper, which are JPEG before anyway
_SHEETS = tuple(SheetKind)
# Chosen, not measured:
_SOLID_LEVEL = 100  # of 255: what is wall to such a share is wall in a smaller picture
_WIDEST_WALL_PX = 13  # of the real plans, whose pixels are 0.05 m
_FACE_PX = 7  # twice as deep as a wall is seen where there is no other side to it


@dataclass(frozen=True, eq=False)
class WallSample:
    """``pixels (H, W, 3)`` uint8 and their ``classes (H, W)``."""

    pixels: Pixels
    classes: Classes

    @cached_property
    def building_px(self) -> int:
        """The longer side of the building or buildings."""
        rows, cols = (np.flatnonzero((self.classes != OUTSIDE).any(axis=k)) for k in (1, 0))
        return int(max(np.ptp(rows), np.ptp(cols)) + 1) if rows.size else 1

    @cached_property
    def wall_px(self) -> float:
        """The mean thickness of walls."""
        return wall_cells(self.classes == WALL)


def resized(sample: WallSample, size: tuple[int, int]) -> WallSample:
    """Return a sample of another width and height; walls get thinner, but stay closed."""
    is_smaller = size[0] < sample.classes.shape[1]
    how = cv2.INTER_AREA if is_smaller else cv2.INTER_LINEAR
    pixels = cv2.resize(sample.pixels, size, interpolation=how)
    found = np.asarray(cv2.resize(sample.classes, size, interpolation=cv2.INTER_NEAREST), np.uint8)
    for value in (WINDOW, WALL) if is_smaller else ():
        mask = (sample.classes == value).astype(np.uint8) * 255
        found[cv2.resize(mask, size, interpolation=cv2.INTER_AREA) > _SOLID_LEVEL] = value
    return WallSample(np.asarray(pixels, np.uint8), found)


def sheet_sample(seed: int, kind: SheetKind) -> WallSample:
    """Draw a sheet of a kind, its building at most :data:`MOST_BUILDING_PX` long."""
    sheet = draw_sheet(seed, kind)
    extents = [storey.on_page.extent for storey in sheet.storeys]
    long_m = max(float(np.ptp(extent, axis=0).max()) for extent in extents)
    factor = min(1.0, MOST_BUILDING_PX * sheet.resolution_m() / long_m)
    pixels = _on_white(sheet.pixels)
    size = [max(1, round(factor * side)) for side in pixels.shape[1::-1]]
    if factor < 1.0:
        pixels = np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)
    H = shrinking((size[0] / sheet.pixels.shape[1], size[1] / sheet.pixels.shape[0]))
    return WallSample(pixels, sheet_classes(sheet, H, (size[1], size[0])))


def _on_white(pixels: Pixels) -> Pixels:
    """Return colours (H, W, 3), of transparent pixels those of white paper."""
    if pixels.shape[2] == 3:
        return pixels
    opacity = pixels[..., 3:].astype(np.float32) / 255.0
    return np.asarray(np.rint(pixels[..., :3] * opacity + 255.0 * (1.0 - opacity)), np.uint8)


def real_samples(data: Path) -> Iterator[tuple[str, WallSample]]:
    """
    Yield the real floorplans of the tune half in ``data``, bare and furnished.

    What people have labelled as a room is floor, and so is what is bright between: doorways.
    What is not, and is narrow or beside it, is wall.
    """
    folder = data / 'bormann'
    for name in TUNE_FLOORS:
        bare = open_image(folder / 'floorplan' / f'{name}.png').pixels
        labels = read_labels(folder / 'room_labels' / f'{name}.png')[::-1]
        classes = _real_classes(bare, labels)
        for path in (
            folder / 'floorplan' / f'{name}.png',
            *sorted((folder / 'furnished').glob(f'{name}_*.png')),
        ):
            yield path.stem, WallSample(open_image(path).pixels, classes)


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


@dataclass(frozen=True)
class _Task:
    seed: int
    kind: SheetKind
    folder: Path


def gather_samples(
    folder: Path,
    sheets: dict[str, int],
    data: Path | None,
    workers: int = 1,
    on_sheet: Callable[[float], None] = lambda _: None,
) -> None:
    """
    Write samples below ``folder``; those that are there already are kept.

    Parameters
    ----------
    folder : gets ``train`` and ``held``, each with pictures and their classes
    sheets : how many of all kinds together for each of the two
    data : folder of the shared data, whose plans are learned from as well; None without
    workers : processes
    on_sheet : is told 1 for each sheet
    """
    tasks = []
    for part, count in sheets.items():
        (folder / part).mkdir(parents=True, exist_ok=True)
        for number in range(count):
            kind = _SHEETS[number % len(_SHEETS)]
            seed = FIRST_SEEDS[part] + number // len(_SHEETS)
            tasks.append(_Task(seed, kind, folder / part))
    for name, sample in real_samples(data) if data is not None else ():
        (folder / 'train').mkdir(parents=True, exist_ok=True)
        _write(folder / 'train' / f'real-{name}', sample, is_photo=False)
    for _ in each_done(_make, tasks, workers):
        on_sheet(1.0)


def _make(task: _Task) -> None:
    cv2.setNumThreads(1)
    stem = task.folder / f'{task.kind.value}-{task.seed}'
    if not _classes_of(stem).is_file():
        is_photo = task.kind in (SheetKind.SCAN, SheetKind.PHONE)
        _write(stem, sheet_sample(task.seed, task.kind), is_photo)


def _classes_of(stem: Path) -> Path:
    return stem.with_name(f'{stem.name}.classes.png')


def _write(stem: Path, sample: WallSample, is_photo: bool) -> None:
    """Write the picture, then its classes, which say that both are there."""
    stored = cv2.cvtColor(sample.pixels, cv2.COLOR_RGB2BGR)
    if is_photo:
        cv2.imwrite(f'{stem}.jpg', stored, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    else:
        cv2.imwrite(f'{stem}.png', stored)
    partial = stem.with_name(f'{stem.name}.partial.png')
    cv2.imwrite(str(partial), sample.classes)
    partial.replace(_classes_of(stem))


def sample_stems(folder: Path, part: str) -> list[Path]:
    """
    Return what :func:`read_sample` reads of a part, ``train`` or ``held``, in order.

    Raises
    ------
    FpnetError
        If there is nothing.
    """
    end = '.classes.png'
    found = sorted((folder / part).glob(f'*{end}'))
    if not found:
        raise FpnetError(f'{folder / part} holds no drawings; gather them with fpnet train-walls')
    return [path.with_name(path.name.removesuffix(end)) for path in found]


def read_sample(stem: Path) -> WallSample:
    """Read what :func:`gather_samples` wrote."""
    picture = next(p for s in ('.png', '.jpg') if (p := Path(f'{stem}{s}')).is_file())
    classes = cv2.imread(str(_classes_of(stem)), cv2.IMREAD_UNCHANGED)
    return WallSample(open_image(picture).pixels, np.asarray(classes, np.uint8))
