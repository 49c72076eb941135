# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Generated storeys and matching pairs at a glance."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from fpnet_core.types import IGNORE
from fpnet_core.viz.segmentation import Colour, draw_grid, draw_segmentation, region_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fpnet_core.sim.pairs import PairScene
    from fpnet_core.types import GridMap

_NO_PARTNER: Colour = (0.25, 0.25, 0.25)
_IGNORED: Colour = (0.7, 0.7, 0.7)
_ABSENT: Colour = (1.0, 1.0, 1.0)
_PATH: Colour = (0.8, 0.0, 0.0)
_TILE_IN = 3.6


def save_plans(drawings: Sequence[tuple[str, GridMap]], columns: int, path: Path) -> None:
    """Write a sheet of titled drawings, ``columns`` in a row."""
    from matplotlib.figure import Figure

    rows = -(-len(drawings) // columns)
    figure = Figure(figsize=(_TILE_IN * columns, _TILE_IN * rows), layout='constrained')
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in axes:
        ax.set_axis_off()
    for ax, (title, grid) in zip(axes, drawings, strict=False):
        draw_grid(ax, grid)
        ax.set_title(title, fontsize=7)
    _save(figure, path)


def save_pairs(scenes: Sequence[PairScene], path: Path) -> None:
    """Write a sheet with plan and submap of each pair, true partners in one colour."""
    from matplotlib.figure import Figure

    columns = 4
    rows = -(-2 * len(scenes) // columns)
    figure = Figure(figsize=(_TILE_IN * columns, _TILE_IN * rows), layout='constrained')
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in axes:
        ax.set_axis_off()
    for i, scene in enumerate(scenes):
        draw_pair(axes[2 * i], axes[2 * i + 1], scene)
    _save(figure, path)


def draw_pair(plan_ax: Axes, sub_ax: Axes, scene: PairScene) -> None:
    """
    Draw a pair's drawing and submap with the robot's path.

    Partners share a colour; submap regions without one are dark, ignored ones grey.
    """
    pair = scene.pair
    labels = pair.sub_labels.tolist()
    seen = set(labels)
    plan_colours = {i: _ABSENT for i in range(len(pair.plan_graph)) if i not in seen}
    sub_colours = {
        i: region_colour(label) if label >= 0 else (_IGNORED if label == IGNORE else _NO_PARTNER)
        for i, label in enumerate(labels)
    }
    draw_grid(plan_ax, scene.plan_segmentation.grid)
    draw_segmentation(plan_ax, scene.plan_segmentation, plan_colours)
    plan_ax.plot(*pair.A_plan_submap.apply(scene.submap.path_xy).T, color=_PATH, linewidth=0.6)
    plan_ax.set_title(f'{pair.family}: {len(pair.plan_graph)} regions', fontsize=7)
    draw_grid(sub_ax, scene.submap.grid)
    draw_segmentation(sub_ax, scene.sub_segmentation, sub_colours)
    sub_ax.plot(*scene.submap.path_xy.T, color=_PATH, linewidth=0.6)
    matched = sum(label >= 0 for label in labels)
    sub_ax.set_title(
        f'{matched} of {len(labels)} regions have a partner, {pair.explored_area_m2:.0f} m²',
        fontsize=7,
    )


def _save(figure: object, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)  # type: ignore[attr-defined]
