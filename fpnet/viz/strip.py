# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Strip plot of a run: submap, matches and best placements at some updates, status over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fpnet.viz.colours import PLACEMENT_COLOURS, TRUTH_COLOUR
from fpnet.viz.pictures import saved_figure
from fpnet.viz.segmentation import (
    draw_grid,
    draw_segmentation,
    partner_colours,
)
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import (
    OCCUPIED,
    LocalizerOutput,
    Segmentation,
    Status,
    Submap,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STATUS_COLOURS: dict[Status, str] = {
    Status.NO_PLAN: '0.85',
    Status.WAITING: '0.7',
    Status.SEARCHING: 'tab:purple',
    Status.AMBIGUOUS: 'tab:orange',
    Status.LOCALIZED: 'tab:green',
    Status.LOST: 'tab:red',
}

# Chosen, not measured:
_MOMENTS = 5
_WALL_STRIDE = 8  # numerical: subsampling of wall cells
_DISTANT_M = 30.0  # larger errors are drawn at the edge
_WIDTH_INCHES, _DPI = 22.0, 90
_ROW_HEIGHTS = (4.0, 4.0, 2.2)


def plot_strip(
    path: Path,
    plan: Segmentation,
    outputs: Sequence[LocalizerOutput],
    truth: PlanarTrajectory,
    errors_m: Sequence[float | None],
    title: str = '',
) -> None:
    """
    Write the strip plot of a run.

    Parameters
    ----------
    path : image file; its folder is created
    plan : the segmented floorplan
    outputs : outputs of all updates
    truth : true poses mapped to ``plan``
    errors_m : error of each output's best placement, None without one
    title : title of the figure
    """
    moments = _moments(outputs)
    with saved_figure(path, (_WIDTH_INCHES, sum(_ROW_HEIGHTS)), _DPI) as figure:
        grid = figure.add_gridspec(3, max(len(moments), 1), height_ratios=_ROW_HEIGHTS)
        start_ns = int(truth.stamps_ns[0])
        for column, output in enumerate(moments):
            plan_axes, sub_axes = (figure.add_subplot(grid[row, column]) for row in (0, 1))
            _draw_plan(plan_axes, plan, output, truth)
            plan_axes.set_title(f'{(output.stamp_ns - start_ns) / NS_PER_S:.0f} s')
            _draw_submap(sub_axes, output)
        timeline = figure.add_subplot(grid[2, :])
        _draw_timeline(timeline, outputs, errors_m, start_ns)
        figure.suptitle(title)


def _moments(outputs: Sequence[LocalizerOutput]) -> list[LocalizerOutput]:
    """Return evenly spaced updates with a submap, with the first and the first localized one."""
    solved = [output for output in outputs if output.segmentation is not None]
    if len(solved) <= _MOMENTS:
        return solved
    chosen = set(np.linspace(0, len(solved) - 1, _MOMENTS).astype(int).tolist())
    claims = [k for k, output in enumerate(solved) if output.status is Status.LOCALIZED]
    if claims and claims[0] not in chosen:
        nearest = min(chosen - {0, len(solved) - 1}, key=lambda k: abs(k - claims[0]))
        chosen = (chosen - {nearest}) | {claims[0]}
    return [solved[k] for k in sorted(chosen)]


def _draw_plan(
    ax: Axes, plan: Segmentation, output: LocalizerOutput, truth: PlanarTrajectory
) -> None:
    """Draw the plan, the true path so far, and the submap's walls at the best three placements."""
    draw_grid(ax, plan.grid)
    draw_segmentation(ax, plan)
    so_far = truth.xy[truth.stamps_ns <= output.stamp_ns]
    walls = _walls(output.submap)
    best = output.estimates.take(np.s_[: len(PLACEMENT_COLOURS)]).apply(walls)
    for placed, colour in reversed(list(zip(best, PLACEMENT_COLOURS, strict=False))):
        ax.plot(*placed.T, '.', color=colour, markersize=2.0)
    ax.plot(*so_far.T, color=TRUTH_COLOUR, linewidth=2.5)
    if len(so_far):
        ax.plot(*so_far[-1], 'o', color=TRUTH_COLOUR, markersize=6)
    ax.set_xlabel('')
    ax.set_ylabel('')


def _walls(submap: Submap | None) -> NDArray[np.float64]:
    if submap is None:
        return np.zeros((0, 2))
    return submap.grid.rc_to_xy(np.argwhere(submap.grid.cells == OCCUPIED)[::_WALL_STRIDE])


def _draw_submap(ax: Axes, output: LocalizerOutput) -> None:
    """Draw the submap's regions in the colours of their matches, and the robot's path."""
    sub = output.segmentation
    assert sub is not None  # see _moments
    draw_grid(ax, sub.grid)
    draw_segmentation(ax, sub, partner_colours(sub, output.match))
    if output.submap is not None:
        ax.plot(*output.submap.path_xy.T, color='black', linewidth=1.0)
    scores = ', '.join(f'{s:.2f}' for s in output.estimates.score[: len(PLACEMENT_COLOURS)])
    ax.set_title(
        f'{output.status.value}, p {output.probability:.2f}; scores {scores or "none"}',
        color=STATUS_COLOURS[output.status],
        fontsize=9,
    )
    ax.set_xlabel('')
    ax.set_ylabel('')


def _draw_timeline(
    ax: Axes,
    outputs: Sequence[LocalizerOutput],
    errors_m: Sequence[float | None],
    start_ns: int,
) -> None:
    """Draw status as background, probability and the error of the best placement over time."""
    times = np.array([(o.stamp_ns - start_ns) / NS_PER_S for o in outputs])
    ends = np.append(times[1:], times[-1:] + np.median(np.diff(times)) if len(times) > 1 else 1.0)
    for output, start, end in zip(outputs, times, ends, strict=False):
        ax.axvspan(start, end, color=STATUS_COLOURS[output.status], alpha=0.35, linewidth=0)
    ax.plot(times, [o.probability for o in outputs], '.-', color='black', label='probability')
    ax.set_ylim(0.0, 1.05)
    ax.set_xlabel('sensor time [s]')
    ax.set_ylabel('probability of the best placement')
    errors = ax.twinx()
    timed = zip(times, errors_m, strict=True)
    known = [(t, min(error, _DISTANT_M)) for t, error in timed if error is not None]
    if known:
        errors.plot(*zip(*known, strict=True), 'x', color=PLACEMENT_COLOURS[0])
    errors.set_yscale('symlog', linthresh=1.0)
    errors.set_ylim(0.0, _DISTANT_M)
    errors.set_ylabel('its error [m]', color=PLACEMENT_COLOURS[0])
    for status in dict.fromkeys(output.status for output in outputs):
        ax.fill_between([], [], color=STATUS_COLOURS[status], alpha=0.35, label=status.value)
    ax.legend(loc='lower right', ncols=6)
