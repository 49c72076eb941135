# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plotly figures of a run report; the page's script updates them over time."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby
from typing import Any

from matplotlib.colors import to_hex
import numpy as np
from numpy.typing import NDArray
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from fpnet.report.moments import SHOWN_PLACEMENTS, door_lines
from fpnet.report.pictures import Picture, pale_picture
from fpnet.report.record import (
    PLACEMENT_SYMBOLS,
    RunRecord,
    best_placement_error,
    path_quality,
    published_errors,
)
from fpnet.viz.colours import (
    ERROR_COLOURS,
    ERROR_RANGE_M,
    ERROR_TICKS_M,
    LIDAR_COLOUR,
    MATCH_COLOUR,
    PLACEMENT_COLOURS,
    TRUTH_COLOUR,
)
from fpnet.viz.differences import DIFFERENCE_COLOURS
from fpnet.viz.segmentation import DOOR_COLOUR, label_xy
from fpnet.viz.strip import STATUS_COLOURS
from fpnet_core.differences import DifferenceKind, Differences
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import LocalizerOutput, Segmentation

HEX_OF_STATUS = {status.value: to_hex(colour) for status, colour in STATUS_COLOURS.items()}

_INK = '#222222'
_DOOR = to_hex(DOOR_COLOUR)
# Chosen, not measured:
_ROOM_NAME = {'size': 11, 'color': '#303030'}
_DOOR_NAME = {'size': 9, 'color': '#8a1010'}
_ROBOT = {'color': _INK, 'size': 20, 'symbol': 'arrow', 'line': {'color': '#ffffff', 'width': 1.5}}
_BEST, _FAINT = 0.6, 0.25  # opacity of walls at the best placement and at runners-up
_SHOWN_POSES = 3000  # numerical: of a line
_DURATION = '#8c959f'
_ROWS = 3  # given: of a timeline with errors
_STAGES = (
    'take', 'segment', 'graph', 'evidence', 'match', 'propose', 'align', 'score', 'wide_scales',
    'mirror', 'storeys',
)  # fmt: skip
_ERROR_TICKS_M = [0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30]
_LONG_TICK, _ROOM_ABOVE, _FAR_LONGER = (
    0.98,
    1.3,
    2.0,
)  # of update durations; the first one compiles
_AROUND_M = 1.0  # margin of the rooms in the initial view
_MARGIN = {'l': 55, 'r': 15, 't': 10, 'b': 40}


def plan_figure(record: RunRecord) -> go.Figure:
    """Return the floorplan with its fixed traces and empty ones that the script fills."""
    figure = go.Figure()
    show_regions(figure, record.plan, pale_picture(record.plan))
    figure.data[0].showlegend = False
    add_rooms(figure, record.plan, names=record.room_names)
    if record.differences is not None:
        add_differences(figure, record.differences)
    if len(record.truth_on_plan):
        x, y = _path(record.truth_on_plan)
        line = {'color': TRUTH_COLOUR, 'width': 1.5, 'dash': 'dot'}
        figure.add_scatter(x=x, y=y, mode='lines', name='true path', line=line, hoverinfo='skip')
    for rank in reversed(range(SHOWN_PLACEMENTS)):
        marker = {'color': PLACEMENT_COLOURS[rank], 'symbol': PLACEMENT_SYMBOLS[rank], 'size': 4}
        name = 'walls at the best placement' if rank == 0 else f'at runner-up {rank}'
        opacity = _FAINT if rank else _BEST
        _add_moving(
            figure, f'placement_{rank}', name, mode='markers', marker=marker, opacity=opacity
        )
    marker = {'color': LIDAR_COLOUR, 'size': 4}
    _add_moving(figure, 'near', 'walls of the last metres', mode='markers', marker=marker)
    _add_path(figure, record)
    line, marker = {'color': MATCH_COLOUR, 'width': 1}, {'size': 4}
    _add_moving(
        figure, 'matches', 'matches', mode='lines+markers', line=line, marker=marker,
        visible='legendonly',
    )  # fmt: skip
    _add_moving(
        figure, 'door_names', 'door numbers', mode='text', textfont=_DOOR_NAME,
        visible='legendonly',
    )  # fmt: skip
    line = {'color': _INK, 'width': 1.5}
    _add_moving(figure, 'ellipse', '95 % ellipse', mode='lines', line=line)
    _add_moving(figure, 'robot', 'robot', mode='markers', marker=_ROBOT, showlegend=False)
    equal_axes(figure, record.plan.grid.frame)
    figure.update_layout(legend={'orientation': 'h', 'y': -0.1})
    return figure


def _add_path(figure: go.Figure, record: RunRecord) -> None:
    """Add the published poses, coloured by error or standard deviation, with a colour bar."""
    name, _ = path_quality(record)
    low, high = np.log10(ERROR_RANGE_M)
    bar = {
        'title': {'text': f'{name} [m]', 'side': 'top'}, 'orientation': 'h', 'thickness': 8,
        'len': 0.4, 'x': 1.0, 'xanchor': 'right', 'y': 1.0, 'yanchor': 'bottom',
        'tickvals': np.log10(ERROR_TICKS_M).tolist(),
        'ticktext': [f'{m:g}' for m in ERROR_TICKS_M],
    }  # fmt: skip
    marker = {
        'size': 5, 'color': [], 'cmin': low, 'cmax': high, 'showscale': True, 'colorbar': bar,
        'colorscale': list(ERROR_COLOURS),
    }  # fmt: skip
    _add_moving(figure, 'published', 'published poses', mode='markers', marker=marker)


def submap_figure() -> go.Figure:
    """Return the empty chart of the submap, which the script fills."""
    figure = go.Figure()
    _add_moving(figure, 'doors', 'doors', mode='lines', line={'color': _DOOR, 'width': 3})
    _add_moving(figure, 'path', 'path', mode='lines', line={'color': _INK, 'width': 1.5})
    _add_moving(figure, 'labels', 'matched floorplan room', mode='text', textfont=_ROOM_NAME)
    _add_moving(figure, 'door_names', 'door numbers', mode='text', textfont=_DOOR_NAME)
    _add_moving(figure, 'robot', 'robot', mode='markers', marker=_ROBOT)
    equal_axes(figure, 'submap')
    figure.update_layout(showlegend=False)
    return figure


def timeline_figure(record: RunRecord) -> go.Figure:
    """Return probability over bands of status, errors with ground truth, and timings."""
    rows = _ROWS if record.truth is not None else _ROWS - 1
    heights = [0.4, 0.4, 0.2] if rows == _ROWS else [0.6, 0.4]
    figure = make_subplots(
        rows=rows, cols=1, shared_xaxes=True, vertical_spacing=0.06, row_heights=heights
    )
    times = record.seconds(np.array([output.stamp_ns for output in record.outputs], np.int64))
    # The first shape is the cursor, which the script moves.
    figure.add_shape(
        type='line', xref=f'x{rows}', yref='paper', x0=0.0, x1=0.0, y0=0.0, y1=1.0,
        line={'color': _INK, 'width': 1.5, 'dash': 'dot'},
    )  # fmt: skip
    _add_probability(figure, record, times)
    if record.truth is not None:
        _add_errors(figure, record, times)
    _add_timings(figure, record, times, rows)
    figure.update_xaxes(title_text='time [s]', row=rows, col=1)
    figure.update_layout(
        template='plotly_white',
        bargap=0.15,
        margin=_MARGIN,
        legend={'orientation': 'h', 'y': -0.12},
        hovermode='x unified',
    )
    return figure


def add_rooms(
    figure: go.Figure,
    segmentation: Segmentation,
    notes: Mapping[int, str] | None = None,
    names: Mapping[int, str] | None = None,
) -> None:
    """Label the rooms with their names, else numbers; area and note are shown on hover."""
    rooms, said, named = segmentation.rooms, notes or {}, names or {}
    places = [label_xy(room) for room in rooms]
    figure.add_scatter(
        x=[x for x, _ in places],
        y=[y for _, y in places],
        text=[named.get(room.id) or str(room.id) for room in rooms],
        mode='text',
        textfont=_ROOM_NAME,
        hovertext=[f'room {r.id}, {r.area_m2:.1f} m²<br>{said.get(r.id, "")}' for r in rooms],
        hoverinfo='text',
        name='room names' if named else 'room numbers',
        showlegend=False,
    )


def add_differences(figure: go.Figure, found: Differences) -> None:
    """Draw the differences, one line each; the legend switches furniture on."""
    for kind, colour in DIFFERENCE_COLOURS.items():
        pieces = [piece for piece in found.pieces if piece.kind is kind and piece.is_likely]
        if not pieces:
            continue
        ends = np.array([[*piece.ends, (np.nan, np.nan)] for piece in pieces]).reshape(-1, 2)
        said = [
            f'{p.kind.value}, {p.length_m:.1f} m, {100.0 * p.confidence:.0f} %' for p in pieces
        ]
        figure.add_scatter(
            x=np.round(ends[:, 0], 2),
            y=np.round(ends[:, 1], 2),
            mode='lines',
            name=kind.value,
            line={'color': to_hex(colour), 'width': 6},
            opacity=0.7,
            hovertext=[text for text in said for _ in range(3)],
            hoverinfo='text',
            visible='legendonly' if kind is DifferenceKind.FURNITURE else True,
        )


def show_regions(figure: go.Figure, segmentation: Segmentation, picture: Picture) -> None:
    """Show a picture of a segmentation with its doors, zoomed to the rooms."""
    figure.add_layout_image(**picture.as_layout_image())
    x, y = door_lines(segmentation)
    line = {'color': _DOOR, 'width': 2}
    figure.add_scatter(x=x, y=y, mode='lines', line=line, name='doors', hoverinfo='skip')
    if segmentation.rooms:
        corners = np.concatenate([room.polygon for room in segmentation.rooms])
        low, high = corners.min(axis=0) - _AROUND_M, corners.max(axis=0) + _AROUND_M
        figure.update_xaxes(range=[float(low[0]), float(high[0])])
        figure.update_yaxes(range=[float(low[1]), float(high[1])])


def _add_moving(figure: go.Figure, key: str, name: str, **style: Any) -> None:
    """Add an empty trace that the script finds by ``meta``."""
    figure.add_scatter(x=[], y=[], name=name, meta=key, hoverinfo='skip', **style)


def equal_axes(figure: go.Figure, frame: str) -> None:
    """Set equal scales of both axes, and label them with the frame."""
    axis = {'showgrid': False, 'zeroline': False, 'constrain': 'domain'}
    figure.update_xaxes(title_text=f'x in {frame} [m]', **axis)
    figure.update_yaxes(title_text=f'y in {frame} [m]', scaleanchor='x', **axis)
    figure.update_layout(template='plotly_white', margin=_MARGIN, dragmode='pan', meta='map')


def thinned(count: int) -> slice:
    """Return the slice of ``count`` poses that a chart shows."""
    return slice(None, None, max(1, -(-count // _SHOWN_POSES)))


def _path(trajectory: PlanarTrajectory) -> NDArray[np.float64]:
    return np.round(trajectory.xy[thinned(len(trajectory))], 2).T


def _add_probability(figure: go.Figure, record: RunRecord, times: NDArray[np.float64]) -> None:
    figure.add_scatter(
        x=times,
        y=[round(output.probability, 3) for output in record.outputs],
        mode='lines+markers',
        line={'color': _INK, 'width': 1.5},
        marker={'size': 4},
        name='probability',
        meta='ink',
        row=1,
        col=1,
    )
    # After the line: plotly adds no band to an empty subplot.
    for status, start, end in _spans(record, times):
        colour = HEX_OF_STATUS[status]
        figure.add_vrect(
            x0=start, x1=end, fillcolor=colour, opacity=0.3, line_width=0, layer='below',
            row=1, col=1,
        )  # fmt: skip
    for status in dict.fromkeys(output.status.value for output in record.outputs):
        marker = {'color': HEX_OF_STATUS[status], 'symbol': 'square', 'size': 12, 'opacity': 0.5}
        figure.add_scatter(x=[None], y=[None], mode='markers', marker=marker, name=status)
    figure.update_yaxes(title_text='probability', range=[0.0, 1.05], row=1, col=1)


def _spans(record: RunRecord, times: NDArray[np.float64]) -> list[tuple[str, float, float]]:
    """Return status, start and end [s] of each sequence of updates with equal status."""
    spans, index = [], 0
    for status, group in groupby(output.status.value for output in record.outputs):
        following = index + len(list(group))
        end = times[min(following, len(times) - 1)]
        spans.append((status, float(times[index]), float(end)))
        index = following
    return spans


def _add_errors(figure: go.Figure, record: RunRecord, times: NDArray[np.float64]) -> None:
    published = published_errors(record)
    shown = thinned(len(published.time_s))
    errors = [best_placement_error(record, output) for output in record.outputs]
    marker = {'color': '#8c959f', 'symbol': 'x', 'size': 5}
    figure.add_scatter(
        x=times, y=errors, mode='markers', marker=marker,
        name='best placement, accepted or not', row=2, col=1,
    )  # fmt: skip
    figure.add_scatter(
        x=published.time_s[shown],
        y=np.round(published.position_m[shown], 3),
        customdata=np.round(published.yaw_deg[shown], 2),
        hovertemplate='%{y:.2f} m, %{customdata:.1f}°',
        mode='lines',
        line={'color': PLACEMENT_COLOURS[0], 'width': 2},
        name='published poses',
        row=2,
        col=1,
    )
    figure.update_yaxes(
        title_text='error [m], log scale', type='log', tickvals=_ERROR_TICKS_M, row=2, col=1
    )


def _stages(output: LocalizerOutput) -> dict[str, float]:
    """Return the durations [ms] of an update's stages, without those that contain others."""
    return {stage: output.timings_ms.get(stage, 0.0) for stage in _STAGES}


def _add_timings(
    figure: go.Figure, record: RunRecord, times: NDArray[np.float64], row: int
) -> None:
    totals = [sum(_stages(output).values()) for output in record.outputs]
    said = [
        '<br>'.join(f'{stage} {ms:.0f} ms' for stage, ms in _stages(output).items() if ms >= 1.0)
        for output in record.outputs
    ]
    figure.add_bar(
        x=times, y=np.round(totals, 1), marker={'color': _DURATION, 'line': {'width': 0}},
        customdata=said, hovertemplate='%{y:.0f} ms<br>%{customdata}', name='update',
        showlegend=False, row=row, col=1,
    )  # fmt: skip
    figure.update_yaxes(title_text='update [ms]', row=row, col=1)
    if not totals:
        return
    most, shown = max(totals), _ROOM_ABOVE * float(np.quantile(totals, _LONG_TICK))
    if most > _FAR_LONGER * shown > 0.0:
        at = times[int(np.argmax(totals))]
        figure.update_yaxes(range=[0.0, shown], row=row, col=1)
        figure.add_annotation(
            text=f'longest update: {most:.0f} ms at {at:.0f} s (cut off)', showarrow=False,
            x=1.0, y=1.0, xanchor='right', yanchor='top',
            xref=f'x{row} domain', yref=f'y{row} domain',
        )  # fmt: skip
