# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plot of a localization run: floorplan, submap, true and estimated path."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fpnet.viz.colours import ERROR_COLOURS, LIDAR_COLOUR, TRUTH_COLOUR
from fpnet.viz.match import shared_colours
from fpnet.viz.pictures import DPI, saved_figure
from fpnet.viz.segmentation import (
    PALE,
    Colour,
    draw_grid,
    draw_segmentation,
    partner_colours,
    turned,
)
from fpnet_core.geometry import Affine2D
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import LocalizerOutput, Segmentation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Chosen, not measured:
_SIZE_INCHES = (16.0, 8.5)
_GAP_NS = 2_000_000_000  # poses further apart than this are not joined by a line


def plot_run(
    path: Path,
    plan: Segmentation,
    output: LocalizerOutput,
    published: PlanarTrajectory,
    truth: PlanarTrajectory | None = None,
    title: str = '',
) -> None:
    """
    Write the plot of a run.

    Parameters
    ----------
    path : image file; its folder is created
    plan : the segmented floorplan
    output : an update, usually the last; without a segmentation only the floorplan is drawn
    published : published poses, frame ``plan``
    truth : true poses, mapped to ``plan``
    title : title of the figure
    """
    with saved_figure(path, _SIZE_INCHES, DPI) as figure:
        draw_run(figure, plan, output, published, truth)
        figure.suptitle(title)


def draw_run(
    figure: Figure,
    plan: Segmentation,
    output: LocalizerOutput,
    published: PlanarTrajectory,
    truth: PlanarTrajectory | None = None,
) -> None:
    """Draw floorplan, paths and submap; parameters as in :func:`plot_run`."""
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    draw_grid(left, plan.grid, PALE)
    draw_segmentation(left, plan, tint=PALE.tint)
    if output.A_plan_odom is not None and output.submap is not None:
        A_plan_submap = output.A_plan_odom @ output.submap.T_odom_submap
        x, y = A_plan_submap.apply(output.submap.recent_xy).T
        left.plot(x, y, '.', color=LIDAR_COLOUR, markersize=2.0, label='walls of the last metres')
    _draw_paths(left, published, truth)
    if output.segmentation is not None:
        colours = _submap_colours(plan, output.segmentation, output)
        yaw_rad = output.estimates[0].A_plan_submap.heading if output.estimates else 0.0
        shown = turned(output.segmentation, yaw_rad)
        draw_grid(right, shown.grid)
        draw_segmentation(right, shown, colours)
    left.legend(loc='best')
    left.set_title('floorplan')
    right.set_title(f'submap: {output.status.value}, p {output.probability:.2f}')


def _submap_colours(
    plan: Segmentation, sub: Segmentation, output: LocalizerOutput
) -> Mapping[int, Colour]:
    """Return submap colours like the plan's, by the placement if there is one, else by match."""
    if output.A_plan_odom is not None and output.submap is not None:
        A_plan_submap: Affine2D = output.A_plan_odom @ output.submap.T_odom_submap
        return shared_colours(plan, sub, A_plan_submap)
    return partner_colours(sub, output.match)


def _draw_paths(ax: Axes, published: PlanarTrajectory, truth: PlanarTrajectory | None) -> None:
    if truth is not None:
        ax.plot(*truth.xy.T, ':', color=TRUTH_COLOUR, linewidth=1.5, label='true path')
        ax.plot(*truth.xy[0], marker='o', color=TRUTH_COLOUR, label='start')
    x, y = _broken_at_gaps(published).T
    ax.plot(x, y, color=ERROR_COLOURS[0], linewidth=2.5, label='published poses')


def _broken_at_gaps(trajectory: PlanarTrajectory) -> NDArray[np.float64]:
    """Return the positions with NaN rows at gaps of more than ``_GAP_NS``."""
    gaps = np.flatnonzero(np.diff(trajectory.stamps_ns) > _GAP_NS) + 1
    return np.insert(trajectory.xy, gaps, np.nan, axis=0)
