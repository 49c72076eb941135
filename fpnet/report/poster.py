# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Poster of a run: one frame with a pale plan, lidar walls, path and caption, for papers."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
import io
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from fpnet.report.page import read_content
from fpnet.report.sheets import ARROW
from fpnet.viz.colours import ERROR_COLOURS, ERROR_RANGE_M, ERROR_TICKS_M, LIDAR_COLOUR
from fpnet.viz.pictures import saved_figure, scale_bar_m
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import rotation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

# Chosen, not measured:
_WIDTH_IN, _TALLEST_IN = 7.2, 8.0  # of the plan; the width is that of a page's text
_STRIP_IN, _LINE_IN, _EDGE_IN = 0.42, 0.17, 0.08  # scale bars, a line of the caption, margins
_DPI, _CAPTION_PT, _LABEL_PT = 250, 9.0, 7.5
_CHARACTERS_PER_IN = 14.5  # of the caption
_WALL_M, _WALL_OPACITY = 0.08, 0.75
_PATH_PT, _RIM_PT, _ROBOT_PT = 2.8, 4.4, 13.0
_GAP_S, _JUMP_M = 2.0, 1.0  # a path is not joined across longer gaps or larger corrections
_MARGIN_M = 1.0
_INK = '#222222'


def write_poster(path: Path, report: Path) -> None:
    """
    Write the poster of a run as PNG, SVG or PDF; its folder is created.

    It shows the plan, the walls of the last metres at each published pose, the path in the colours
    of its errors or standard deviations, and one caption. Without a published pose it shows the
    walls of the submap at the best placement, and the caption says so.

    Raises
    ------
    FpnetError
        If ``report`` is not the report of a run.
    """
    content = read_content(report)
    if not content['data'].get('moments'):
        raise FpnetError(f'{report} has no update to show; give the folder of a run')
    lines = wrap(_caption(content['data']), int(_WIDTH_IN * _CHARACTERS_PER_IN))
    low, high = _limits(content)
    width_m, height_m = (high - low).tolist()
    width_in = min(_WIDTH_IN, _TALLEST_IN * width_m / height_m)
    plan_in = width_in * height_m / width_m
    below_in = _STRIP_IN + _LINE_IN * (len(lines) + 1)
    with saved_figure(path, (_WIDTH_IN + 2 * _EDGE_IN, plan_in + below_in), _DPI) as figure:
        figure.set_layout_engine('none')
        wide, tall = figure.get_size_inches()
        left = 0.5 * (1.0 - width_in / wide)
        ax = figure.add_axes((left, below_in / tall, width_in / wide, plan_in / tall))
        ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        _draw_plan(ax, content['figures']['plan']['layout']['images'][0])
        _draw_walls(ax, content['data']['moments'], 72.0 * width_in / width_m)
        colours = _draw_path(ax, content['data']['published'])
        _draw_robot(ax, content['data']['moments'][-1])
        ax.set_axis_off()
        strip = (below_in - _STRIP_IN) / tall
        _draw_scale(figure, strip, width_in / width_m, width_m)
        if colours is not None:
            _draw_colour_bar(figure, strip, colours, _quality(content))
        caption = strip - 0.3 * _LINE_IN / tall
        figure.text(_EDGE_IN / wide, caption, '\n'.join(lines), fontsize=_CAPTION_PT, va='top')


def _caption(data: Mapping[str, Any]) -> str:
    summary = data['summary']
    is_found = any(moment['A_plan_near'] for moment in data['moments'])
    walls = 'walls seen by lidar over the last metres, at the published poses'
    if not is_found:
        walls = 'walls of the submap at the best placement, which was not accepted'
    return f'{summary["title"]}. {summary["answer"]}. Blue: {walls}.'


def _quality(content: Mapping[str, Any]) -> str:
    traces = {trace.get('meta'): trace for trace in content['figures']['plan']['data']}
    title: str = traces['published']['marker']['colorbar']['title']['text']
    return title


def _limits(content: Mapping[str, Any]) -> tuple[Array, Array]:
    """Return the lower and upper corner [m]: rooms and path."""
    layout, path = content['figures']['plan']['layout'], content['data']['published']
    image = layout['images'][0]
    whole = ([image['x'], image['x'] + image['sizex']], [image['y'] - image['sizey'], image['y']])
    ranges = [layout[name].get('range') or whole[k] for k, name in enumerate(('xaxis', 'yaxis'))]
    low, high = np.array(ranges, dtype=np.float64).T
    if path['x']:
        xy = np.array([path['x'], path['y']])
        low = np.minimum(low, xy.min(axis=1) - _MARGIN_M)
        high = np.maximum(high, xy.max(axis=1) + _MARGIN_M)
    return low, high


def _draw_plan(ax: Axes, image: Mapping[str, Any]) -> None:
    pixels = Image.open(io.BytesIO(base64.b64decode(image['source'].split(',', 1)[1])))
    x, y = image['x'], image['y']
    extent = (x, x + image['sizex'], y - image['sizey'], y)
    ax.imshow(pixels.convert('RGBA'), extent=extent, aspect='auto', interpolation='antialiased')


def _draw_walls(ax: Axes, moments: Sequence[Mapping[str, Any]], pt_per_m: float) -> None:
    """Draw the walls of the last metres at each published pose, else at the best placement."""
    known = [(m['A_plan_near'], m['near'] if m['near'][0] else m['walls']) for m in moments]
    placed = [_placed(A, xy) for A, xy in known if A is not None]
    if not placed and moments[-1]['placements']:
        placed = [_placed(moments[-1]['placements'][0]['A_plan_submap'], moments[-1]['walls'])]
    if placed:
        x, y = np.concatenate(placed).T
        size = (_WALL_M * pt_per_m) ** 2
        colour = (LIDAR_COLOUR, _WALL_OPACITY)
        ax.scatter(x, y, s=size, color=colour, linewidths=0.0, rasterized=True)


def _placed(A: Sequence[Sequence[float]], columns: Sequence[Sequence[float]]) -> Array:
    matrix, xy = np.array(A, dtype=np.float64), np.array(columns, dtype=np.float64).T
    placed: Array = xy.reshape(-1, 2) @ matrix[:, :2].T + matrix[:, 2]
    return placed


def _draw_path(ax: Axes, path: Mapping[str, Any]) -> ScalarMappable | None:
    """Draw the published poses in the colours of their quality; None without poses."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap, LogNorm

    times = np.array(path['time_s'], dtype=np.float64)
    xy = np.column_stack([path['x'], path['y']]).astype(np.float64).reshape(-1, 2)
    if len(xy) < 2:
        return None
    steps = np.stack([xy[:-1], xy[1:]], axis=1)
    is_joined = (np.diff(times) <= _GAP_S) & (
        np.linalg.norm(np.diff(xy, axis=0), axis=1) < _JUMP_M
    )
    joined = list(steps[is_joined])
    quality = np.array(path['quality_m'][1:], dtype=np.float64)
    lines = LineCollection(
        joined,
        array=np.clip(quality[is_joined], *ERROR_RANGE_M),
        cmap=LinearSegmentedColormap.from_list('errors', ERROR_COLOURS),
        norm=LogNorm(*ERROR_RANGE_M),
        linewidths=_PATH_PT,
        capstyle='round',
    )
    ax.add_collection(LineCollection(joined, colors='white', linewidths=_RIM_PT, capstyle='round'))
    ax.add_collection(lines)
    return lines


def _draw_robot(ax: Axes, moment: Mapping[str, Any]) -> None:
    """Draw the robot's last position, hollow if not accepted; an arrow if its heading is known."""
    A = moment['A_plan_near'] or (
        moment['placements'] and moment['placements'][0]['A_plan_submap']
    )
    if not A or not moment['path'][0]:
        return
    [at] = _placed(A, [column[-1:] for column in moment['path']])
    marker: Any = 'o'
    if moment['heading'] is not None:
        marker = ARROW @ rotation(moment['heading'] + np.arctan2(A[1][0], A[0][0])).T
    face = _INK if moment['A_plan_near'] else 'white'
    ax.plot(*at, marker=marker, markersize=_ROBOT_PT, color=_INK, markerfacecolor=face, zorder=5)


def _draw_scale(figure: Figure, strip: float, in_per_m: float, width_m: float) -> None:
    """Draw a scale bar at the left of the strip, whose lower edge is ``strip``."""
    wide, tall = figure.get_size_inches()
    length_m = scale_bar_m(width_m)
    ax = figure.add_axes(
        (_EDGE_IN / wide, strip + 0.2 / tall, length_m * in_per_m / wide, 0.04 / tall)
    )
    ax.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    ax.set_axis_off()
    ax.fill_between([0.0, 1.0], 0.0, 1.0, color=_INK, linewidth=0)
    ax.annotate(
        f'{length_m:g} m', (0.0, 0.0), xytext=(0, -2), textcoords='offset points', va='top',
        fontsize=_LABEL_PT,
    )  # fmt: skip


def _draw_colour_bar(figure: Figure, strip: float, colours: ScalarMappable, name: str) -> None:
    wide, tall = figure.get_size_inches()
    width = 0.32
    ax = figure.add_axes(
        (1.0 - width - 2 * _EDGE_IN / wide, strip + 0.2 / tall, width, 0.06 / tall)
    )
    bar = figure.colorbar(colours, cax=ax, orientation='horizontal', ticks=list(ERROR_TICKS_M))
    bar.ax.set_xticklabels([f'{m:g}' for m in ERROR_TICKS_M], fontsize=_LABEL_PT)
    bar.ax.minorticks_off()
    bar.ax.tick_params(length=2, pad=1)
    bar.outline.set_visible(False)
    ax.annotate(
        name, (0.0, 0.5), xycoords='axes fraction', xytext=(-6, 0), textcoords='offset points',
        ha='right', va='center', fontsize=_LABEL_PT,
    )  # fmt: skip
