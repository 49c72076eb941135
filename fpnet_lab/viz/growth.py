# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plots of computation time and memory against storey area."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fpnet.viz.pictures import saved_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fpnet_lab.evaluation.speed.growth import Grown

_SHOWN = ('segment', 'evidence', 'match', 'propose', 'align', 'score', 'mirror', 'wide_scales')
_PLAN, _TICK, _MEMORY = '#1f6fb4', '#d1495b', '#3b7d4f'


def save_growth(storeys: Sequence[Grown], path: Path) -> None:
    """Write plots of times, memory and the stages of an update against a storey's area."""
    with saved_figure(path, (11.0, 3.6), 110) as figure:
        times, memory, parts = figure.subplots(1, 3)
        area = np.array([storey.area_m2 for storey in storeys])
        times.plot(area, [s.plan[1] for s in storeys], 'o-', color=_PLAN, label='floorplan, once')
        times.plot(area, [s.update[1] for s in storeys], 'o-', color=_TICK, label='searching tick')
        times.set_ylabel('processor time [s]')
        times.set_yscale('log')
        times.legend(frameon=False)
        memory.plot(area, [1e-9 * s.peak_bytes for s in storeys], 'o-', color=_MEMORY)
        memory.set_ylabel('memory of the process [GB]')
        memory.set_ylim(bottom=0.0)
        _draw_parts(parts, area, storeys)
        for ax in (times, memory, parts):
            ax.set_xscale('log')
            ax.set_xlabel('storey [m²]')
            ax.grid(alpha=0.3)


def _draw_parts(ax: Axes, area: np.ndarray, storeys: Sequence[Grown]) -> None:
    for stage in _SHOWN:
        ax.plot(area, [s.stages_s.get(stage, np.nan) for s in storeys], '.-', label=stage)
    ax.set_yscale('log')
    ax.set_ylabel('stage of a tick, by the clock [s]')
    ax.legend(frameon=False, fontsize=7, ncols=2)
