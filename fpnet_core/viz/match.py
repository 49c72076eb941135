# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Two maps beside each other, matched regions in one colour, and one drawn over the other."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import Affine2D
from fpnet_core.viz.segmentation import Colour, draw_grid, draw_segmentation, region_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fpnet_core.localizer import MapMatch
    from fpnet_core.types import Segmentation

_UNMATCHED: Colour = (0.75, 0.75, 0.75)
_SUBMAP_WALLS: Colour = (0.1, 0.35, 0.8)
_SHARED_AREA = 0.3  # regions that share this part of the smaller one are shown alike


def shared_colours(
    plan: Segmentation, sub: Segmentation, A_plan_sub: Affine2D
) -> dict[int, Colour]:
    """
    Colour of each submap region: that of the plan region below it, grey where there is none.

    ``A_plan_sub`` places the submap; the region that covers most of it lends the colour.
    """
    from shapely import Polygon

    plan_shapes = [(r.id, r.label, Polygon(r.polygon).buffer(0)) for r in plan.regions]
    colours = {}
    for region in sub.regions:
        shape = Polygon(A_plan_sub.apply(region.polygon)).buffer(0)
        shared = [
            (shape.intersection(other).area / min(shape.area, other.area), plan_id)
            for plan_id, label, other in plan_shapes
            if label is region.label and shape.intersects(other)
        ]
        best, plan_id = max(shared, default=(0.0, -1))
        colours[region.id] = region_colour(plan_id) if best >= _SHARED_AREA else _UNMATCHED
    return colours


def draw_walls_on_plan(
    ax: Axes, plan: Segmentation, walls: NDArray[np.float64], A_plan_sub: Affine2D
) -> None:
    """Draw the plan and the submap's wall samples ``(P, 2)`` placed on it."""
    draw_grid(ax, plan.grid)
    x, y = A_plan_sub.apply(walls).T
    ax.plot(x, y, '.', color=_SUBMAP_WALLS, markersize=1.5, label='walls of the submap')


def save_map_match(result: MapMatch, path: Path) -> None:
    """Write a picture of both maps, their regions, and the submap's walls on the plan."""
    from matplotlib.figure import Figure

    plan, sub = result.plan.segmentation, result.sub.segmentation
    best = result.comparison.estimates[0].A_plan_submap if result.A_plan_sub else None
    figure = Figure(figsize=(18, 6.5), layout='constrained')
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
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
