# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plot of two maps side by side, matched regions in one colour, and of their overlay."""

from __future__ import annotations

from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from fpnet.viz.colours import LIDAR_COLOUR
from fpnet.viz.pictures import DPI, saved_figure
from fpnet.viz.segmentation import (
    PALE,
    Colour,
    draw_grid,
    draw_segmentation,
    partner_colours,
    region_colour,
    turned,
)
from fpnet_core.geometry import Affine2D
from fpnet_core.localizer import MapMatchStatus
from fpnet_core.raster.rays import values_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fpnet_core.localizer import MapMatch
    from fpnet_core.types import Segmentation

# Chosen, not measured:
SIZE_INCHES = (18.0, 7.0)
_FAINT = 0.35  # opacity of walls at a placement that was not accepted
_CAPTION_CHARACTERS = 170  # of a line
_NOT_PLACED = 'no placement was found'
_NOT_ACCEPTED = 'best placement, not accepted'
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


def save_map_match(result: MapMatch, path: Path) -> None:
    """Write a plot of both maps, their regions, and the submap's walls on the plan."""
    with saved_figure(path, SIZE_INCHES, DPI) as figure:
        draw_map_match(figure, result)


def draw_map_match(figure: Figure, result: MapMatch) -> None:
    """
    Draw the submap's walls on the plan, both maps with their regions, and the result.

    The submap is turned to the plan. Walls at a placement that was not accepted are faint.
    """
    plan, sub = result.plan.segmentation, result.sub.segmentation
    estimates = result.candidates.estimates
    best = estimates[0].A_plan_submap if estimates else None
    is_accepted = result.status is MapMatchStatus.MATCHED
    placed, left, right = figure.subplots(1, 3)
    draw_grid(placed, plan.grid, PALE)
    draw_segmentation(placed, plan, tint=PALE.tint)
    if best is not None:
        x, y = best.apply(result.sub.evidence.walls).T
        opacity = 1.0 if is_accepted else _FAINT
        placed.plot(x, y, '.', color=LIDAR_COLOUR, markersize=1.8, alpha=opacity)
    titles = (_NOT_PLACED, _NOT_ACCEPTED, 'walls of the submap on the plan')
    placed.set_title(titles[(best is not None) + is_accepted])
    draw_grid(left, plan.grid)
    draw_segmentation(left, plan)
    left.set_title(f'plan: {len(plan.rooms)} rooms, {len(plan.doors)} doors')
    colours = shared_colours(plan, sub, best) if best is not None and is_accepted else None
    shown = sub if best is None else turned(sub, best.heading)
    draw_grid(right, shown.grid)
    draw_segmentation(right, shown, colours)
    right.set_title(f'submap: {len(sub.rooms)} rooms, {len(sub.doors)} doors')
    said = f'{result.status.value} (p {result.probability:.2f}): {result.reason}'
    figure.suptitle('\n'.join(wrap(said, _CAPTION_CHARACTERS)), x=0.01, ha='left')
