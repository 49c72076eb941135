# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A floorplan's rooms, and which of them look like others."""

from __future__ import annotations

from pathlib import Path

from fpnet_core.types import Segmentation
from fpnet_core.viz.segmentation import Colour, draw_grid, draw_segmentation

# Chosen, not measured:
UNIQUE: Colour = (0.35, 0.75, 0.4)
ALIKE_INSIDE: Colour = (0.98, 0.78, 0.25)
ALIKE_WITH_NEIGHBOURS: Colour = (0.9, 0.3, 0.25)

_NAMES = {
    'like no other': UNIQUE,
    'like another from inside': ALIKE_INSIDE,
    'like another even with the rooms behind its doors': ALIKE_WITH_NEIGHBOURS,
}
_EDGE_INCHES, _LEGEND_INCHES, _DPI = 10.0, 2.4, 110  # chosen


def similarity_colours(
    segmentation: Segmentation, alone: frozenset[int], together: frozenset[int]
) -> dict[int, Colour]:
    """Colour of each room: how much of the plan it takes to tell it from others."""
    return {
        room.id: ALIKE_WITH_NEIGHBOURS
        if room.id in together
        else ALIKE_INSIDE
        if room.id in alone
        else UNIQUE
        for room in segmentation.rooms
    }


def save_plan_check(
    path: Path, segmentation: Segmentation, alone: frozenset[int], together: frozenset[int]
) -> None:
    """
    Write the picture: rooms and doors, and beside or below them the rooms that look alike.

    ``alone`` are the rooms that look like another place from inside, ``together`` those that do
    even with their neighbours.
    """
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    rows, columns = segmentation.grid.shape
    aspect = rows / columns
    shape = (2, 1) if aspect < 1.0 else (1, 2)
    size = (_EDGE_INCHES * shape[1], _EDGE_INCHES * shape[0] * aspect + _LEGEND_INCHES)
    figure = Figure(figsize=size, layout='constrained')
    # The legend in a part of its own: Matplotlib before 3.7 has no place for it outside of axes.
    heights = [size[1] - _LEGEND_INCHES, _LEGEND_INCHES]
    plans, below = figure.subfigures(2, 1, squeeze=False, height_ratios=heights)[:, 0]
    plain, coloured = plans.subplots(*shape)
    draw_grid(plain, segmentation.grid)
    draw_segmentation(plain, segmentation, with_ids=True)
    plain.set_title(f'{len(segmentation.rooms)} rooms, {len(segmentation.doors)} doors')
    draw_grid(coloured, segmentation.grid)
    colours = similarity_colours(segmentation, alone, together)
    draw_segmentation(coloured, segmentation, colours, with_ids=True)
    coloured.set_title('rooms that look alike')
    handles = [Patch(color=colour, label=name) for name, colour in _NAMES.items()]
    below.legend(handles=handles, loc='center', frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=_DPI)
