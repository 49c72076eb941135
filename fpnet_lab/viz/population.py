# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Distributions of generated and real storeys in one figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fpnet.viz.pictures import saved_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Values = Mapping[str, NDArray[np.float64]]
"""Measured values by quantity; one value for each room, door or storey."""

# Chosen, not measured:
_PANELS = {
    'room_area_m2': ('room area [m²]', (2.0, 300.0), 'log'),
    'aspect': ('long over short side of a room', (1.0, 4.0), 'linear'),
    'door_width_m': ('door width [m]', (0.5, 2.6), 'linear'),
    'rectangularity': ('share of its rectangle a room fills', (0.4, 1.0), 'linear'),
    'doors_per_room': ('doors of a room', (0.0, 8.0), 'linear'),
    'rooms_per_plan': ('rooms of a storey', (0.0, 90.0), 'linear'),
}
_GENERATED, _REAL, _SINGLE = '#1f6fb4', '#d1495b', '#e9a9b2'
_COLUMNS = 3
_LEGEND_INCHES = 0.4  # chosen: height of the legend at the top
_PER_STOREY = 'rooms_per_plan'  # one value per storey: no distribution within a storey


def save_population(
    generated: Values, real: Values, real_storeys: Sequence[Values], path: Path
) -> None:
    """
    Write cumulative distributions of generated, of real, and of each single real storey.

    All three need the quantities of :data:`_PANELS`.
    """
    rows = -(-len(_PANELS) // _COLUMNS)
    size = (3.6 * _COLUMNS, 2.9 * rows + _LEGEND_INCHES)
    with saved_figure(path, size, 110) as figure:
        heights = [_LEGEND_INCHES, 2.9 * rows]
        above, panels = figure.subfigures(2, 1, squeeze=False, height_ratios=heights)[:, 0]
        axes = panels.subplots(rows, _COLUMNS).ravel()
        for ax, name in zip(axes, _PANELS, strict=True):
            singles = [] if name == _PER_STOREY else [storey[name] for storey in real_storeys]
            _draw_panel(ax, name, generated[name], real[name], singles)
        handles, labels = axes[0].get_legend_handles_labels()
        above.legend(handles, labels, loc='center', ncols=3, frameon=False)


def _draw_panel(
    ax: Axes,
    name: str,
    generated: NDArray[np.float64],
    real: NDArray[np.float64],
    singles: Sequence[NDArray[np.float64]],
) -> None:
    label, limits, scale = _PANELS[name]
    for k, values in enumerate(singles):
        _draw_steps(ax, values, _SINGLE, 0.8, 'single real storeys' if k == 0 else None)
    _draw_steps(ax, generated, _GENERATED, 2.2, 'generated storeys')
    _draw_steps(ax, real, _REAL, 2.2, 'real storeys')
    ax.set_xscale(scale)
    ax.set_xlim(*limits)
    ax.set_ylim(0.0, 1.0)
    ax.set_xlabel(label)
    ax.set_ylabel('share at most so large')
    ax.grid(alpha=0.3)


def _draw_steps(
    ax: Axes, values: NDArray[np.float64], colour: str, width: float, label: str | None
) -> None:
    ordered = np.sort(values)
    shares = np.arange(1, len(ordered) + 1) / len(ordered)
    ax.step(ordered, shares, where='post', color=colour, linewidth=width, label=label)
