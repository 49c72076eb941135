# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plot of two maps side by side, matched regions in one colour, and of their overlay."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fpnet.viz.pictures import saved_figure
from fpnet.viz.segmentation import (
    Colour,
    draw_grid,
    draw_segmentation,
    partner_colours,
    region_colour,
)
from fpnet_core.geometry import Affine2D
from fpnet_core.raster.rays import values_at

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from fpnet_core.localizer import MapMatch
    from fpnet_core.types import Segmentation

# Chosen, not measured:
_SUBMAP_WALLS: Colour = (0.1, 0.35, 0.8)
_SHARED_AREA = 0.3  # least share of a room's cells on one plan room, to get its colour
_SAME_DOOR_M = 1.0
_CELL_STRIDE = 7  # numerical: subsampling of cells


def shared_colours(
    plan: Segmentation, sub: Segmentation, A_plan_sub: Affine2D
) -> dict[int, Colour]:
    """
    Return the colour of each submap region: that of the plan region below it, grey without one.

    ``A_plan_sub`` places the submap. A room takes the colour of the plan room below most of its
    cells, a door that of the nearest plan door.
    """
    colours = partner_colours(sub, None)
    for room in sub.rooms:
        cells = np.argwhere(sub.labels == room.id + 1)[::_CELL_STRIDE]
        rc = plan.grid.xy_to_rc(A_plan_sub.apply(sub.grid.rc_to_xy(cells)))
        below = values_at(plan.labels, rc, 0)
        counts = np.bincount(below)
        counts[0] = 0
        if len(cells) and counts.max() >= _SHARED_AREA * len(cells):
            colours[room.id] = region_colour(int(counts.argmax()) - 1)
    plan_doors = np.array([door.centroid for door in plan.doors]).reshape(-1, 2)
    for door in sub.doors:
        gaps = np.linalg.norm(plan_doors - A_plan_sub.apply(door.centroid), axis=1)
        if len(gaps) and gaps.min() <= _SAME_DOOR_M:
            colours[door.id] = region_colour(plan.doors[int(gaps.argmin())].id)
    return colours


def draw_walls_on_plan(
    ax: Axes, plan: Segmentation, walls: NDArray[np.float64], A_plan_sub: Affine2D
) -> None:
    """Draw the plan and the submap's wall samples ``(P, 2)`` placed on it."""
    draw_grid(ax, plan.grid)
    x, y = A_plan_sub.apply(walls).T
    ax.plot(x, y, '.', color=_SUBMAP_WALLS, markersize=1.5, label='walls of the submap')


def save_map_match(result: MapMatch, path: Path) -> None:
    """Write a plot of both maps, their regions, and the submap's walls on the plan."""
    with saved_figure(path, (18, 6.5), 110) as figure:
        draw_map_match(figure, result)


def draw_map_match(figure: Figure, result: MapMatch) -> None:
    """Draw both maps, their regions, and the submap's walls on the plan, side by side."""
    plan, sub = result.plan.segmentation, result.sub.segmentation
    best = result.candidates.estimates[0].A_plan_submap if result.A_plan_sub else None
    axes = figure.subplots(1, 3)
    draw_grid(axes[0], plan.grid)
    draw_segmentation(axes[0], plan)
    axes[0].set_title(f'plan: {len(plan.rooms)} rooms, {len(plan.doors)} doors')
    draw_grid(axes[1], sub.grid)
    draw_segmentation(axes[1], sub, None if best is None else shared_colours(plan, sub, best))
    axes[1].set_title(f'submap: {len(sub.rooms)} rooms, {len(sub.doors)} doors')
    if best is not None:
        draw_walls_on_plan(axes[2], plan, result.sub.evidence.walls, best)
    axes[2].set_title(
        f'{result.status.value}: score {result.score:.2f}, p {result.probability:.2f}'
    )
