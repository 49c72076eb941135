# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Page of a run: floorplan, growing submap, hypotheses and timeline with one slider."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.colors import to_rgb
import numpy as np
import plotly.graph_objects as go

from fpnet.report.charts import (
    HEX_OF_STATUS,
    plan_figure,
    submap_figure,
    thinned,
    timeline_figure,
)
from fpnet.report.moments import changes, moments, shown_ticks
from fpnet.report.page import write_page
from fpnet.report.record import PLACEMENT_SIGNS, RunRecord
from fpnet.viz.colours import PLACEMENT_COLOURS

_ELSEWHERE = ('reason', 'causes', 'outdated')  # shown elsewhere on the page
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # given: of sRGB channels, ITU-R BT.709
_UNITS = ('m', 's', 'ms', 'deg')


def write_run_report(path: Path | str, record: RunRecord) -> None:
    """
    Write the report as one self-contained HTML file; its folder is created.

    A run of many updates is thinned out for the slider, not for the timeline.
    """
    write_page(
        Path(path),
        'run.html.j2',
        run_figures(record),
        run_data(record, moments(record)),
        title=record.title,
        summary=record.summary,
        figures_shown=_shown(record),
        causes=record.causes,
        ticks=len(shown_ticks(record.outputs)),
    )


def run_figures(record: RunRecord) -> dict[str, go.Figure]:
    """Return the charts of a run, by their names in the script of the page."""
    return {
        'plan': plan_figure(record),
        'submap': submap_figure(),
        'timeline': timeline_figure(record),
    }


def run_data(record: RunRecord, shown: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the data of the page's script as plain values; ``shown`` are its updates."""
    return {
        'moments': shown,
        'changes': changes(record),
        'published': published(record, thinned(len(record.published))),
        'status_colours': HEX_OF_STATUS,
        'status_inks': {name: _ink_on(colour) for name, colour in HEX_OF_STATUS.items()},
        'placement_colours': PLACEMENT_COLOURS,
        'placement_signs': PLACEMENT_SIGNS,
    }


def published(record: RunRecord, which: slice) -> dict[str, list[float]]:
    """Return times and positions of some published poses as columns."""
    poses = record.published
    return {
        'time_s': np.round(record.seconds(poses.stamps_ns[which]), 2).tolist(),
        'x': np.round(poses.xy[which, 0], 2).tolist(),
        'y': np.round(poses.xy[which, 1], 2).tolist(),
    }


def _ink_on(colour: str) -> str:
    """Return black or white, whichever is easier to read on a colour (WCAG 2, contrast)."""
    channels = np.array(to_rgb(colour))
    linear = np.where(
        channels <= 0.04045,  # noqa: PLR2004
        channels / 12.92,
        ((channels + 0.055) / 1.055) ** 2.4,
    )
    luminance = float(linear @ _LUMINANCE)
    on_white, on_black = 1.05 / (luminance + 0.05), (luminance + 0.05) / 0.05
    return '#ffffff' if on_white > on_black else '#000000'


def _shown(record: RunRecord) -> list[tuple[str, str]]:
    """Return the run's metrics as names with units and texts, without missing values."""
    return [
        (_named(name), _text(value))
        for name, value in record.figures.items()
        if value is not None and name not in _ELSEWHERE
    ]


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return 'yes' if value else 'no'
    return f'{value:.2f}' if isinstance(value, float) else str(value)


def _named(name: str) -> str:
    """Turn ``path_to_first_pose_m`` into ``path to first pose [m]``."""
    words = name.split('_')
    units = [word for word in words if word in _UNITS]
    rest = ' '.join(word for word in words if word not in _UNITS)
    return f'{rest} [{units[-1]}]' if units else rest
