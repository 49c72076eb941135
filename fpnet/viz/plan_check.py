# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plot of a floorplan's rooms and of those that look alike."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from fpnet.plan_check.self_similarity import SelfSimilarity
from fpnet.viz.pictures import DPI, saved_figure
from fpnet.viz.segmentation import Colour, draw_grid, draw_segmentation
from fpnet_core.types import Segmentation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Chosen, not measured:
UNIQUE: Colour = (0.35, 0.75, 0.4)
ALIKE_INSIDE: Colour = (0.98, 0.78, 0.25)
ALIKE_WITH_NEIGHBOURS: Colour = (0.9, 0.3, 0.25)

_NAMES = {
    'unique room': UNIQUE,
    'looks like another one from inside': ALIKE_INSIDE,
    'looks like another one even with the adjacent rooms': ALIKE_WITH_NEIGHBOURS,
}
_EDGE_INCHES, _LEGEND_INCHES = 10.0, 1.3  # chosen


def similarity_colours(
    segmentation: Segmentation, similarity: SelfSimilarity
) -> dict[int, Colour]:
    """Return the colour of each room: unique, or with twins alone or with its neighbours."""
    return {
        room.id: ALIKE_WITH_NEIGHBOURS
        if room.id in similarity.with_neighbours
        else ALIKE_INSIDE
        if room.id in similarity.alone
        else UNIQUE
        for room in segmentation.rooms
    }


def plan_check_inches(segmentation: Segmentation) -> tuple[float, float]:
    """Return the width and height [inch] of the plot of a floorplan."""
    rows, columns = _panels(segmentation)
    aspect = segmentation.grid.shape[0] / segmentation.grid.shape[1]
    return _EDGE_INCHES * columns, _EDGE_INCHES * rows * aspect + _LEGEND_INCHES


def draw_plan_check(
    figure: Figure, segmentation: Segmentation, similarity: SelfSimilarity
) -> None:
    """Draw rooms and doors, and beside or below them the rooms that look alike."""
    from matplotlib.patches import Patch

    # The legend has its own subfigure: Matplotlib before 3.7 cannot place it outside of axes.
    heights = [plan_check_inches(segmentation)[1] - _LEGEND_INCHES, _LEGEND_INCHES]
    plans, below = figure.subfigures(2, 1, squeeze=False, height_ratios=heights)[:, 0]
    plain, coloured = plans.subplots(*_panels(segmentation))
    draw_grid(plain, segmentation.grid)
    draw_segmentation(plain, segmentation, with_ids=True)
    plain.set_title(f'{len(segmentation.rooms)} rooms, {len(segmentation.doors)} doors')
    draw_grid(coloured, segmentation.grid)
    colours = similarity_colours(segmentation, similarity)
    draw_segmentation(coloured, segmentation, colours, with_ids=True)
    coloured.set_title('rooms that look alike')
    handles = [Patch(color=colour, label=name) for name, colour in _NAMES.items()]
    below.legend(handles=handles, loc='center', frameon=False)


def save_plan_check(path: Path, segmentation: Segmentation, similarity: SelfSimilarity) -> None:
    """Write the plot of :func:`draw_plan_check`."""
    with saved_figure(path, plan_check_inches(segmentation), DPI) as figure:
        draw_plan_check(figure, segmentation, similarity)


def _panels(segmentation: Segmentation) -> tuple[int, int]:
    """Return the rows and columns of both plots: stacked if the plan is wide."""
    rows, columns = segmentation.grid.shape
    return (2, 1) if rows < columns else (1, 2)
