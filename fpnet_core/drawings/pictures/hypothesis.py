# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plan hypothesis: the building in a drawing as cells and segmented rooms."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.building import SeenBuilding, see_building
from fpnet_core.drawings.pictures.robot_maps import map_cells
from fpnet_core.drawings.pictures.view import on_paper, view_of
from fpnet_core.drawings.stated import SaidScale
from fpnet_core.drawings.types import Array, Box, Drawing, ReadOptions
from fpnet_core.errors import MapFormatError
from fpnet_core.raster.pixels import cut_from, map_points, pixel_to_xy, shrinking
from fpnet_core.segmentation import segment_unknown_scale
from fpnet_core.segmentation.moved import rescaled_rooms
from fpnet_core.segmentation.scale import estimate_metres_per_unit, segment_at
from fpnet_core.segmentation.scale_model import ScalePrior
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Segmentation

NOMINAL_M = 0.05
"""Nominal edge of a cell of unknown scale; all results are ratios then. Numerical."""

_SEGMENTED_PX = 1200  # numerical: longer side of the grid that is segmented
_ROUNDS = 2  # numerical: of scale and segmentation; enough for the parser warnings


@dataclass(frozen=True, eq=False)
class PlanHypothesis:
    """
    A building found in a drawing.

    ``cells (H, W)`` with row 0 at the top; ``H_cell_pixel (3, 3)`` maps the drawing's pixels to
    them; ``segmentation`` is in nominal metres (:data:`NOMINAL_M` per cell) and may be coarser.
    ``said`` is the stated scale, used for segmentation; ``known_factor`` is the number of true
    metres per nominal metre by it, None if not stated or stated by mistake. ``seen`` is the output
    of the network, None for a robot map; ``storeys`` are in the drawing's pixels.
    """

    cells: NDArray[np.int8]
    H_cell_pixel: Array
    segmentation: Segmentation
    said: SaidScale
    known_factor: float | None = None
    seen: SeenBuilding | None = None
    storeys: tuple[Box, ...] = ()
    is_straightened: bool = False

    @property
    def prior(self) -> ScalePrior | None:
        """Network's prior of true metres per nominal metre; None for a robot map."""
        return None if self.seen is None else nominal_scale(self.seen)

    @property
    def how(self) -> str:
        """Method that found the building, in a few words."""
        return 'walls and rooms segmented by the network' if self.seen else 'a robot map'

    @property
    def H_plan_pixel(self) -> Array:
        """Map (3, 3) from the drawing's pixels to nominal metres of the segmentation."""
        to_plan = pixel_to_xy(self.segmentation.grid).matrix
        return np.asarray(to_plan @ shrinking(1.0 / stride(self.cells)) @ self.H_cell_pixel)

    def with_cells(self, cells: NDArray[np.int8], config: SegmentationConfig) -> PlanHypothesis:
        """Return the building with other cells (H, W), segmented again."""
        rooms, factor = rooms_of(cells, config, self.known_factor, self.prior)
        return replace(self, cells=cells, segmentation=rooms, known_factor=factor)

    def cut_at(self, grid: GridMap) -> Segmentation | None:
        """Return the segmentation on a grid of the same cells; None if made at another scale."""
        factor, metres = self.known_factor, grid.resolution / NOMINAL_M
        if stride(self.cells) > 1 or factor is None or not math.isclose(factor, metres):
            return None
        rooms = rescaled_rooms(self.segmentation, metres)
        return replace(rooms, grid=replace(grid, cells=rooms.grid.cells))


def find_building(
    drawing: Drawing, options: ReadOptions, config: SegmentationConfig
) -> PlanHypothesis:
    """
    Return the building that ``drawing`` shows.

    Raises
    ------
    MapFormatError
        If it shows none, or lacks the requested storey.
    """
    said = SaidScale.of(drawing, options)
    part, H_part_pixel = _part(drawing.pixels, options.crop)
    cells = None if options.storey else map_cells(part, NOMINAL_M)
    if cells is not None:
        rooms, factor = _rooms(cells, H_part_pixel, said, config)
        return PlanHypothesis(cells, H_part_pixel, rooms, said, factor)
    part, H_part_pixel = on_paper(part, H_part_pixel)
    view = view_of(part)
    seen = see_building(view, options.storey)
    if seen is None:
        raise MapFormatError(
            f'{drawing.name} shows no building: no lines enclose rooms; expected a floorplan '
            f'with walls that stand out from the paper{"".join(f"; {n}" for n in drawing.notes)}'
        )
    H = seen.H_cell_pixel @ H_part_pixel
    to_pixel = np.asarray(np.linalg.inv(view.H_view_pixel @ H_part_pixel), np.float64)
    storeys = tuple(_boxed(to_pixel, box) for box in seen.boxes)
    rooms, factor = _rooms(seen.cells, H, said, config, nominal_scale(seen))
    return PlanHypothesis(seen.cells, H, rooms, said, factor, seen, storeys, view.is_straightened)


def _part(pixels: NDArray[np.uint8], crop: Box | None) -> tuple[NDArray[np.uint8], Array]:
    """Return the cropped pixels, and the map (3, 3) from the drawing's pixels to them."""
    left, top, right, bottom = crop or (0, 0, pixels.shape[1], pixels.shape[0])
    return pixels[top:bottom, left:right], cut_from(left, top)


def _rooms(
    cells: NDArray[np.int8],
    H_cell_pixel: Array,
    said: SaidScale,
    config: SegmentationConfig,
    prior: ScalePrior | None = None,
) -> tuple[Segmentation, float | None]:
    cell_m = said.cell_m(H_cell_pixel, cells.shape)
    return rooms_of(cells, config, cell_m and cell_m / NOMINAL_M, prior)


def nominal_scale(seen: SeenBuilding) -> ScalePrior:
    """Return the network's prior of true metres per nominal metre."""
    return seen.scale.per(1.0 / NOMINAL_M)


def rooms_of(
    cells: NDArray[np.int8],
    config: SegmentationConfig,
    known_factor: float | None = None,
    prior: ScalePrior | None = None,
) -> tuple[Segmentation, float | None]:
    """
    Return the segmentation of cells (H, W) of :data:`NOMINAL_M`, reduced if large.

    ``known_factor`` is the number of true metres per nominal metre. If it is None or
    implausible, the scale is estimated with the ``prior``, and the second return value is
    None; else it is the factor.
    """
    step = stride(cells)
    rows, cols = (-(-side // step) for side in cells.shape)
    padded = np.full((rows * step, cols * step), UNKNOWN, dtype=np.int8)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    blocks = padded.reshape(rows, step, cols, step)
    wall, free = (blocks == OCCUPIED).any(axis=(1, 3)), (blocks == FREE).all(axis=(1, 3))
    coarse = np.select([wall, free], [OCCUPIED, FREE], UNKNOWN).astype(np.int8)
    grid = GridMap(coarse[::-1], NOMINAL_M * step)
    if known_factor is not None:
        segmentation = segment_at(grid, config, known_factor)
        if not _is_slip(segmentation, known_factor):
            return segmentation, known_factor
    return segment_unknown_scale(grid, config, _ROUNDS, prior)[0], None


def _is_slip(segmentation: Segmentation, factor: float) -> bool:
    """Return whether a stated scale is a mistake: it gives no rooms, or they contradict it."""
    if not segmentation.rooms:
        return True
    scale = estimate_metres_per_unit(segmentation, factor)
    return replace(
        scale, factor=scale.factor / factor, low=scale.low / factor, high=scale.high / factor
    ).is_scale_conflict


def stride(cells: NDArray[np.int8]) -> int:
    """Return by how much cells (H, W) are reduced for segmentation."""
    return int(-(-max(cells.shape) // _SEGMENTED_PX))


def _boxed(H: Array, box: Box) -> Box:
    """Return the bounding box of ``box`` mapped by ``H``."""
    left, top, right, bottom = box
    corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]], float)
    mapped = map_points(H, corners)
    first, last = np.rint(mapped.min(axis=0)).astype(int), np.rint(mapped.max(axis=0)).astype(int)
    return int(first[0]), int(first[1]), int(last[0]), int(last[1])
