# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images of generated storeys and matching pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fpnet.viz.pictures import saved_figure
from fpnet.viz.segmentation import Colour, draw_grid, draw_segmentation, region_colour
from fpnet_core.matches import IGNORE
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fpnet_lab.sim.pairs.pair import MappedPair

# Chosen, not measured:
_NO_PARTNER: Colour = (0.25, 0.25, 0.25)
_IGNORED: Colour = (0.7, 0.7, 0.7)
_ABSENT: Colour = (1.0, 1.0, 1.0)
_PATH: Colour = (0.8, 0.0, 0.0)
_SHEET_IN = 15.0
_TITLE_PT = 7.5
_DPI = 120
_PAGE_CELLS = 300  # longer side of the image of a map
_PAPER = 0.8


def save_gallery(
    drawings: Sequence[tuple[str, GridMap]],
    pairs: Sequence[MappedPair],
    path: Path,
    columns: int = 6,
) -> None:
    """
    Write one sheet: titled drawings, then matching pairs with plan and submap side by side.

    ``columns`` is even. True partners of a pair have the same colour.
    """
    rows = [-(-len(drawings) // columns), -(-2 * len(pairs) // columns)]
    tile_in = _SHEET_IN / columns
    with saved_figure(path, (_SHEET_IN, tile_in * sum(rows)), _DPI) as figure:
        axes = figure.subplots(sum(rows), columns, squeeze=False).ravel()
        for ax in axes:
            ax.set_axis_off()
        for ax, (title, grid) in zip(axes, drawings, strict=False):
            draw_page(ax, grid, round(tile_in * _DPI))
            ax.set_title(title, fontsize=_TITLE_PT)
        first = rows[0] * columns
        for i, mapped in enumerate(pairs):
            draw_pair(axes[first + 2 * i], axes[first + 2 * i + 1], mapped)


def draw_page(ax: Axes, grid: GridMap, size_px: int) -> None:
    """Draw a drawing in shades of grey, so that thin lines stay visible at ``size_px``."""
    shades = np.select([grid.cells == OCCUPIED, grid.cells == FREE], [0.0, 1.0], _PAPER)
    factor = -(-max(grid.shape) // size_px)
    rows, columns = (cells // factor * factor for cells in grid.shape)
    blocks = shades[:rows, :columns].reshape(rows // factor, factor, columns // factor, factor)
    page = blocks.mean(axis=(1, 3)) ** factor  # keeps lines of one cell dark
    page[(blocks == _PAPER).all(axis=(1, 3))] = _PAPER
    ax.imshow(page, origin='lower', cmap='gray', vmin=0.0, vmax=1.0, interpolation='antialiased')


def bold(grid: GridMap) -> GridMap:
    """Return a grid with fewer, larger cells and closed walls."""
    factor = -(-max(grid.shape) // _PAGE_CELLS)
    pad = [(0, -cells % factor) for cells in grid.shape]
    cells = np.pad(grid.cells, pad, constant_values=UNKNOWN)
    rows, columns = (size // factor for size in cells.shape)
    blocks = cells.reshape(rows, factor, columns, factor)
    # Walls take precedence over free space, free space over unknown space.
    return replace(grid, cells=blocks.max(axis=(1, 3)), resolution=grid.resolution * factor)


def draw_pair(plan_ax: Axes, sub_ax: Axes, mapped: MappedPair) -> None:
    """
    Draw a pair's drawing and its submap with the robot's path.

    Partners share a colour; submap regions without a partner are dark, ignored ones grey.
    """
    pair = mapped.pair
    labels = pair.sub_labels.tolist()
    seen = set(labels)
    plan_colours = {i: _ABSENT for i in range(len(pair.plan_graph)) if i not in seen}
    sub_colours = {
        i: region_colour(label) if label >= 0 else (_IGNORED if label == IGNORE else _NO_PARTNER)
        for i, label in enumerate(labels)
    }
    draw_grid(plan_ax, bold(mapped.plan_segmentation.grid))
    draw_segmentation(plan_ax, mapped.plan_segmentation, plan_colours)
    plan_ax.plot(*pair.A_plan_submap.apply(mapped.submap.path_xy).T, color=_PATH, linewidth=0.6)
    plan_ax.set_title(f'{pair.family}: {len(pair.plan_graph)} regions', fontsize=_TITLE_PT)
    draw_grid(sub_ax, bold(mapped.submap.grid))
    draw_segmentation(sub_ax, mapped.sub_segmentation, sub_colours)
    sub_ax.plot(*mapped.submap.path_xy.T, color=_PATH, linewidth=0.6)
    matched = sum(label >= 0 for label in labels)
    sub_ax.set_title(
        f'{matched} of {len(labels)} with a partner, {pair.explored_area_m2:.0f} m²',
        fontsize=_TITLE_PT,
    )
