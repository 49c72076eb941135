# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plot of a parsed drawing over the original: rooms, doors, doubtful parts and scale."""

from __future__ import annotations

from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet.plan_check.verdict import PlanVerdict
from fpnet.viz.pictures import saved_figure, scale_bar_m
from fpnet.viz.segmentation import DOOR_COLOUR, label_xy, region_colour
from fpnet_core.drawings.types import Reading
from fpnet_core.drawings.wording import said_of
from fpnet_core.raster.pixels import column_to_xy, shrinking
from fpnet_core.types import OCCUPIED, Region, Segmentation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

# Chosen, not measured:
_LONG_SIDE_IN = 12.0
_DPI = 130
_SHOWN_PX = 2400  # larger drawings are downsampled
_ROOM_PT, _AREA_PT, _DOOR_PT = 9.0, 5.5, 6.0  # font sizes of numbers and areas
_PALE = 0.45  # remaining contrast of the drawing below the rooms
_STOREY = (0.1, 0.3, 0.8)
_DOUBTFUL = (0.95, 0.0, 0.75)
_WALL = (20, 60, 140)  # red, green, blue
_LEAST_IN = 5.0  # least width, for the title above a tall drawing
_PT, _LINE_IN, _CHARACTER_IN = 9, 0.16, 0.085  # title: font size, height and width of characters


def save_reading(reading: Reading, path: Path, verdict: PlanVerdict) -> None:
    """Write the plot of a parsed drawing with its description and verdict."""
    width, height = reading.drawing.size
    said = [*said_of(reading), *verdict.headlines()]
    inch = _LONG_SIDE_IN / max(height, width)
    wide = max(width * inch, _LEAST_IN) + 0.4
    lines = [part for line in said for part in wrap(line, int(wide / _CHARACTER_IN))]
    with saved_figure(path, (wide, height * inch + _LINE_IN * (len(lines) + 3)), _DPI) as figure:
        # A title of the figure may be wider than the axes.
        figure.suptitle('\n'.join(lines), fontsize=_PT, x=0.01, ha='left')
        draw_reading(figure.add_subplot(), reading)


def draw_reading(ax: Axes, reading: Reading) -> None:
    """Draw a parsed plan over its drawing, in the drawing's pixels, y down."""
    segmentation = reading.segmentation
    width, height = reading.drawing.size
    to_pixel = _H_pixel_plan(reading)
    shown = _shown(reading.drawing.pixels)
    H_shown_pixel = shrinking((shown.shape[1] / width, shown.shape[0] / height))
    walls = _with_walls(_paled(shown), reading, H_shown_pixel @ to_pixel)
    ax.imshow(walls, extent=(-0.5, width - 0.5, height - 0.5, -0.5))
    for room in segmentation.rooms:
        outline = _mapped(to_pixel, room.polygon)
        ax.fill(*outline.T, color=region_colour(room.id), alpha=0.5, linewidth=0)
        _number_room(ax, room, to_pixel)
    for portal in segmentation.portals:
        ends = _mapped(to_pixel, portal.ends)
        ax.plot(*ends.T, color=DOOR_COLOUR, linewidth=1.8)
        _number(ax, str(portal.door), ends.mean(axis=0), _DOOR_PT, DOOR_COLOUR)
    if len(reading.storeys) > 1:
        for number, box in enumerate(reading.storeys, start=1):
            _box(ax, box, _STOREY, f'storey {number}', '-')
    for doubtful in reading.doubtful:
        _box(ax, doubtful.box, _DOUBTFUL, f'{doubtful.what}?', '-', 1.6)
    _scale_bar(ax, to_pixel, segmentation, (height, width))
    ax.set_xlim(-0.5, width - 0.5)
    ax.set_ylim(height - 0.5, -0.5)


def _number_room(ax: Axes, room: Region, to_pixel: Array) -> None:
    """Write a room's number, as used in messages, and its area below."""
    middle = _mapped(to_pixel, np.array([label_xy(room)]))[0]
    _number(ax, str(room.id), middle, _ROOM_PT, 'black', weight='bold')
    ax.annotate(
        f'{room.area_m2:.0f} m²',
        tuple(middle),
        xytext=(0.0, -0.5 * _ROOM_PT),
        textcoords='offset points',
        ha='center',
        va='top',
        fontsize=_AREA_PT,
    )


def _number(
    ax: Axes, number: str, xy: Array, size_pt: float, colour: Any, weight: str = 'normal'
) -> None:
    """Write a number with a white outline, readable on walls."""
    from matplotlib.patheffects import withStroke

    rim = [withStroke(linewidth=2.0, foreground='white')]
    ax.annotate(
        number, tuple(xy), ha='center', va='center', fontsize=size_pt, color=colour,
        fontweight=weight, path_effects=rim,
    )  # fmt: skip


def _shown(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the drawing, downsampled to the size of the plot if it is larger."""
    factor = _SHOWN_PX / max(pixels.shape[:2])
    if factor >= 1.0:
        return pixels
    size = [max(1, round(factor * side)) for side in pixels.shape[1::-1]]
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)


def _paled(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    pale = 255.0 - _PALE * (255.0 - pixels.astype(np.float32))
    return np.asarray(np.rint(pale), dtype=np.uint8)


def _with_walls(pixels: NDArray[np.uint8], reading: Reading, to_pixel: Array) -> NDArray[np.uint8]:
    """Return the image with the detected walls in one colour."""
    grid = reading.grid
    A_plan_cell = column_to_xy(grid.T_frame_grid, grid.resolution).matrix
    size = pixels.shape[1], pixels.shape[0]
    walls = (grid.cells == OCCUPIED).astype(np.float32)
    share = cv2.warpPerspective(walls, to_pixel @ A_plan_cell, size)[..., None]
    mixed = (1.0 - share) * pixels + share * np.array(_WALL, np.float32)
    return np.asarray(np.rint(mixed), dtype=np.uint8)


def _H_pixel_plan(reading: Reading) -> Array:
    """Return the homography from metres of the plan to the drawing's upright pixels."""
    return np.asarray(np.linalg.inv(reading.H_plan_image))


def _mapped(H: Array, points: Array) -> Array:
    homogeneous = points @ H[:, :2].T + H[:, 2]
    return np.asarray(homogeneous[:, :2] / homogeneous[:, 2:])


def _box(
    ax: Axes,
    box: tuple[int, int, int, int],
    colour: tuple[float, float, float],
    name: str,
    style: str,
    width: float = 1.0,
) -> None:
    left, top, right, bottom = box
    x, y = [left, right, right, left, left], [top, top, bottom, bottom, top]
    ax.plot(x, y, color=colour, linewidth=width, linestyle=style)
    ax.annotate(name, (left, top), color=colour, fontsize=7, va='bottom')


def _scale_bar(
    ax: Axes, to_pixel: Array, segmentation: Segmentation, shape: tuple[int, int]
) -> None:
    """Draw a scale bar of a round number of metres in the lower left corner."""
    height, width = shape
    middle = segmentation.grid.rc_to_xy(np.array(segmentation.grid.shape) / 2.0)
    ends = _mapped(to_pixel, middle + np.array([[0.0, 0.0], [1.0, 0.0]]))
    pixels_per_m = float(np.linalg.norm(ends[1] - ends[0]))
    metres = scale_bar_m(width / pixels_per_m)
    left, y = 0.02 * width, 0.98 * height
    ax.plot([left, left + metres * pixels_per_m], [y, y], color='black', linewidth=3)
    ax.annotate(f'{metres:g} m', (left, y), xytext=(0, 4), textcoords='offset points', fontsize=8)
