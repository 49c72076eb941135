# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plot of a robot map over the drawing, coloured by the distance to drawn walls."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fpnet.alignment import Alignment
from fpnet.viz.pictures import saved_figure
from fpnet.viz.segmentation import draw_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Chosen, not measured:
_FAR_M = 0.5  # distance at the end of the colour scale
_SHOWN_M = 0.05  # shorter displacements are not drawn
_ARROW_SCALE = 5.0  # arrows are drawn this much longer, as displacements are centimetres
_KEY_M = 0.2  # length of the arrow in the key
_FURNITURE = (0.75, 0.6, 0.2)  # as in plots of differences
_MARGIN_M = 2.0  # around the observed walls
_WIDTH_IN = 11.0
_TALLEST = 1.5  # height of the picture over its width, at most


def draw_alignment(ax: Axes, aligned: Alignment) -> None:
    """
    Draw the drawing, the observed walls on it and how it must be deformed to fit them.

    Walls are coloured by their distance to drawn ones, by the transform alone.
    """
    walls = aligned.walls
    draw_grid(ax, aligned.plan.grid)
    if walls.is_furniture.any():
        x, y = walls.xy[walls.is_furniture].T
        ax.plot(x, y, '.', color=_FURNITURE, markersize=1.5, label='furniture')
        ax.legend(loc='upper right', bbox_to_anchor=(1.0, -0.06), markerscale=6.0)
    xy, off_m = walls.xy[~walls.is_furniture], walls.off_m[~walls.is_furniture]
    order = np.argsort(off_m, kind='stable')  # far ones on top
    points = ax.scatter(
        xy[order, 0], xy[order, 1], c=off_m[order], s=4.0, cmap='turbo', vmin=0.0, vmax=_FAR_M,
        linewidths=0.0,
    )  # fmt: skip
    bar = ax.figure.colorbar(points, ax=ax, shrink=0.7, extend='max')
    bar.set_label('observed wall to drawn wall [m]')
    shown = [
        each
        for each in walls.on_grid()
        if aligned.metres * np.hypot(each['dx'], each['dy']) >= _SHOWN_M
    ]
    if shown:
        x, y, dx, dy = (np.array([each[key] for each in shown]) for key in ('x', 'y', 'dx', 'dy'))
        arrows = ax.quiver(
            x, y, _ARROW_SCALE * dx, _ARROW_SCALE * dy, angles='xy', scale_units='xy', scale=1.0,
            width=0.003, color='black',
        )  # fmt: skip
        key = _ARROW_SCALE * _KEY_M / aligned.metres
        said = f'{_KEY_M} m from drawn to observed'
        ax.quiverkey(arrows, 0.85, 1.02, key, said, labelpos='W', coordinates='axes')
    low, high = walls.xy.min(axis=0), walls.xy.max(axis=0)
    margin = _MARGIN_M / aligned.metres
    ax.set_xlim(low[0] - margin, high[0] + margin)
    ax.set_ylim(low[1] - margin, high[1] + margin)
    whole = walls.whole
    ax.set_title(
        loc='left',
        label=f'{whole["walls_m"]:.0f} m of observed wall: median {whole["median_m"]:.2f} m, '
        f'90 % within {whole["p90_m"]:.2f} m',
    )


def save_alignment(aligned: Alignment, path: Path) -> None:
    """Write the plot of :func:`draw_alignment`."""
    width, height = np.ptp(aligned.walls.xy, axis=0)
    tall = min(float(height / max(width, 1e-9)), _TALLEST)
    with saved_figure(path, (_WIDTH_IN, _WIDTH_IN * 0.85 * tall + 1.5), 110) as figure:
        draw_alignment(figure.add_subplot(), aligned)
