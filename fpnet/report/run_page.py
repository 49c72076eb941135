# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Page of a run: result, floorplan, growing submap and timeline with one slider."""

from __future__ import annotations

from collections.abc import Mapping
import math
from pathlib import Path
from typing import Any

from matplotlib.colors import to_rgb
import numpy as np
import plotly.graph_objects as go

from fpnet.report.answer import all_figures, answer_line, main_figures
from fpnet.report.charts import (
    HEX_OF_STATUS,
    plan_figure,
    submap_figure,
    thinned,
    timeline_figure,
)
from fpnet.report.moments import changes, moments
from fpnet.report.page import write_page
from fpnet.report.record import PLACEMENT_SIGNS, RunRecord, path_quality
from fpnet.viz.colours import PLACEMENT_COLOURS

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # given: of sRGB channels, ITU-R BT.709


def write_run_report(path: Path | str, record: RunRecord) -> None:
    """
    Write the report as one self-contained HTML file; its folder is created.

    A run of many updates is thinned out for the slider, not for the timeline.
    """
    data = run_data(record, moments(record))
    write_page(
        Path(path),
        'run.html.j2',
        run_figures(record),
        data,
        **run_values(data['summary'], len(data['moments'])),
    )


def run_values(summary: Mapping[str, Any], updates: int) -> dict[str, Any]:
    """Return the values of the page's template; ``summary`` is that of :func:`run_data`."""
    head = {'title': summary['title'], 'summary': summary['source']}
    return {'run': summary, 'updates': updates, **head}


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
        'summary': {
            'title': record.heading_line,
            'source': record.title if record.building else record.summary,
            'answer': answer_line(record),
            'status': record.outputs[-1].status.value if record.outputs else '',
            'reason': record.outputs[-1].reason if record.outputs else '',
            'main': main_figures(record),
            'all': all_figures(record),
            'causes': [cause.as_json() for cause in record.causes],
        },
    }


def published(record: RunRecord, which: slice) -> dict[str, list[float | None]]:
    """Return times, positions and errors, or standard deviations, of some poses as columns."""
    poses, (_, quality_m) = record.published, path_quality(record)
    return {
        'time_s': np.round(record.seconds(poses.stamps_ns[which]), 2).tolist(),
        'x': np.round(poses.xy[which, 0], 2).tolist(),
        'y': np.round(poses.xy[which, 1], 2).tolist(),
        'quality_m': [None if math.isnan(m) else round(m, 3) for m in quality_m[which].tolist()],
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
