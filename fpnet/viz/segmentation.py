# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plots of grids and their regions on matplotlib Axes, in metres."""

from __future__ import annotations

from collections.abc import Mapping
import colorsys
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely.geometry import Polygon
from shapely.ops import polylabel

from fpnet_core.geometry import SE2
from fpnet_core.matches import MatchResult
from fpnet_core.raster.pixels import corners_xy
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Region, Segmentation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Colour = tuple[float, float, float]


class Shades(NamedTuple):
    """Greys of walls and of unknown cells in [0, 1], and the opacity of a room's colour."""

    wall: float
    unknown: float
    tint: float


SHADES = Shades(wall=0.25, unknown=0.93, tint=0.55)
"""Shades of maps whose rooms are the subject. Chosen."""

PALE = Shades(wall=0.62, unknown=1.0, tint=0.18)
"""Shades of a plan below observed walls and paths. Chosen."""

DOOR_COLOUR: Colour = (0.85, 0.1, 0.1)
"""Colour of doors in all plots. Chosen."""

# Chosen, not measured:
_UNMATCHED: Colour = (0.75, 0.75, 0.75)
_MARGIN_M, _CELL_STRIDE = 0.5, 5  # around the known cells; numerical: subsampling of these
# Hues a golden angle apart stay distinct for any number of regions.
_GOLDEN = 0.6180339887498949  # numerical


def region_colour(region_id: int) -> Colour:
    """Return the fixed colour (r, g, b) in [0, 1] of a region id."""
    hue = (region_id * _GOLDEN) % 1.0
    value = (0.95, 0.75, 0.85)[region_id % 3]
    return colorsys.hsv_to_rgb(hue, 0.55, value)


def partner_colours(sub: Segmentation, match: MatchResult | None) -> dict[int, Colour]:
    """Return the colour of each submap region: its partner's on the plan, grey without one."""
    colours = dict.fromkeys((region.id for region in sub.regions), _UNMATCHED)
    if match is not None:
        colours |= {sub_id: region_colour(p) for p, sub_id in match.pairs.tolist()}
    return colours


def label_xy(region: Region) -> tuple[float, float]:
    """
    Return the position of a region's label: the centre of its largest inscribed circle.

    The centroid of an L-shaped corridor may lie in another room.
    """
    parts = shapely.get_parts(shapely.make_valid(Polygon(region.polygon)))
    middle = polylabel(max(parts, key=shapely.area), 0.1)
    return float(middle.x), float(middle.y)


def turned(segmentation: Segmentation, yaw_rad: float) -> Segmentation:
    """Return a map whose frame is turned, so that it is shown in the axes of another map."""
    T = SE2.from_xy_yaw(0.0, 0.0, yaw_rad)
    grid = segmentation.grid
    return replace(
        segmentation,
        grid=replace(grid, T_frame_grid=T @ grid.T_frame_grid),
        regions=tuple(
            replace(each, polygon=T.apply(each.polygon), centroid=T.apply(each.centroid))
            for each in segmentation.regions
        ),
        portals=tuple(replace(each, ends=T.apply(each.ends)) for each in segmentation.portals),
    )


def draw_grid(ax: Axes, grid: GridMap, shades: Shades = SHADES) -> None:
    """Draw the known part of a grid in its own frame: free white, the rest in shades of grey."""
    grey = np.full(grid.shape, shades.unknown)
    grey[grid.cells == FREE] = 1.0
    grey[grid.cells == OCCUPIED] = shades.wall
    show_raster(ax, grid, grey, cmap='gray', vmin=0.0, vmax=1.0)
    known = grid.rc_to_xy(np.argwhere(grid.cells != UNKNOWN)[::_CELL_STRIDE])
    shown = known if len(known) else corners_xy(grid)
    ax.set_xlim(shown[:, 0].min() - _MARGIN_M, shown[:, 0].max() + _MARGIN_M)
    ax.set_ylim(shown[:, 1].min() - _MARGIN_M, shown[:, 1].max() + _MARGIN_M)
    ax.set_aspect('equal')
    ax.set_xlabel(f'x in {grid.frame} [m]')
    ax.set_ylabel(f'y in {grid.frame} [m]')


def draw_segmentation(
    ax: Axes,
    segmentation: Segmentation,
    colours: Mapping[int, Colour] | None = None,
    with_ids: bool = False,
    tint: float = SHADES.tint,
) -> None:
    """
    Draw rooms as tinted cells and doors as lines over the content of ``ax``.

    ``colours`` overrides the colour of a region by id, so that matched regions of plan and
    submap can share one; ``with_ids`` writes each room's id into it; ``tint`` is the opacity of
    rooms.
    """
    chosen = colours or {}
    cells = np.zeros((*segmentation.labels.shape, 4))
    for room in segmentation.rooms:
        colour = chosen.get(room.id, region_colour(room.id))
        cells[segmentation.labels == room.id + 1] = (*colour, tint)
        if with_ids:
            ax.annotate(str(room.id), label_xy(room), ha='center', va='center', fontsize=7)
    show_raster(ax, segmentation.grid, cells)
    for portal in segmentation.portals:
        style = '-' if portal.rooms[1] is not None else ':'
        colour = chosen.get(portal.door, DOOR_COLOUR)
        ax.plot(*portal.ends.T, color=colour, linewidth=2.0, linestyle=style)


def painted(
    segmentation: Segmentation,
    colours: Mapping[int, Colour] | None = None,
    shades: Shades = SHADES,
) -> NDArray[np.uint8]:
    """
    Return the cells as an image ``(H, W, 3)`` in sRGB, row 0 at the grid's row 0.

    Grey as in :func:`draw_grid`, rooms tinted as in :func:`draw_segmentation`; the lines of doors
    are not drawn.
    """
    chosen = colours or {}
    cells = segmentation.grid.cells
    known = [cells == FREE, cells == OCCUPIED]
    greys = np.select(known, [1.0, shades.wall], shades.unknown)
    image = np.repeat(greys[..., None], 3, axis=2)
    tints = np.zeros((len(segmentation.regions) + 1, 3))
    for room in segmentation.rooms:
        tints[room.id + 1] = chosen.get(room.id, region_colour(room.id))
    inside = segmentation.labels > 0
    image[inside] = (1.0 - shades.tint) * image[inside]
    image[inside] += shades.tint * tints[segmentation.labels[inside]]
    return np.asarray(np.rint(255.0 * image), dtype=np.uint8)


def show_raster(ax: Axes, grid: GridMap, image: NDArray[np.float64], **options: Any) -> None:
    """Show an image of the grid's cells at the grid's pose."""
    from matplotlib.transforms import Affine2D as PlotAffine

    height_m, width_m = (cells * grid.resolution for cells in grid.shape)
    ax.imshow(
        image,
        origin='lower',
        extent=(0.0, width_m, 0.0, height_m),
        interpolation='nearest',
        transform=PlotAffine(grid.T_frame_grid.matrix) + ax.transData,
        **options,
    )
