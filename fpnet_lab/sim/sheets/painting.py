# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rendering of artwork to pixels or PDF with matplotlib."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.lengths import INCH_M
from fpnet_lab.sim.sheets.artwork import Arcs, Area, Array, Artwork, Letters, Lines, Pen, Stroke

_INCH_MM, _POINT_IN = 1e3 * INCH_M, 1.0 / 72.0  # physical: by definition
CAPITAL_SHARE = 0.72
"""Height of a capital relative to the font size. Chosen."""

# Chosen, not measured:
_SETTINGS: Any = {'path.simplify': False, 'pdf.fonttype': 42, 'lines.scale_dashes': False}


def rasterise(artwork: Artwork, resolution_m: float) -> NDArray[np.uint8]:
    """Render the artwork to RGBA pixels (H, W, 4), row 0 at the top."""
    dots_per_inch = _INCH_MM * 1e-3 * artwork.denominator / resolution_m
    with rc_context(_SETTINGS):
        # matplotlib rounds down to whole pixels, hence the offset of 0.01.
        pixels = np.round(np.array(artwork.size_m) / resolution_m) + 0.01
        figure = _figure(artwork, dots_per_inch, pixels / dots_per_inch)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()  # type: ignore[no-untyped-call]
        shown = canvas.buffer_rgba()  # type: ignore[no-untyped-call]
        return np.array(shown, dtype=np.uint8)


def write_pdf(artwork: Artwork, path: Path) -> None:
    """Write the artwork as a PDF page of the paper's size, with vector lines and text."""
    with rc_context(_SETTINGS):
        # Without dates, equal sheets give equal files.
        figure = _figure(artwork, 1.0 / _POINT_IN, np.array(artwork.size_mm) / _INCH_MM)
        figure.savefig(path, format='pdf', metadata={'CreationDate': None})


def _figure(artwork: Artwork, dots_per_inch: float, inches: Array) -> Figure:
    """Return a figure of size ``inches (2,)`` with a single axes in page metres."""
    figure = Figure(figsize=(float(inches[0]), float(inches[1])), dpi=dots_per_inch)
    figure.patch.set_alpha(0.0 if artwork.paper is None else 1.0)
    figure.patch.set_facecolor(artwork.paper or (1.0, 1.0, 1.0))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_xlim(0.0, artwork.size_m[0])
    axes.set_ylim(0.0, artwork.size_m[1])
    points_per_m = 1e3 / artwork.denominator / _INCH_MM / _POINT_IN
    for order, mark in enumerate(artwork.strokes):
        _paint(axes, mark, points_per_m, order)
    return figure


def _paint(axes: Axes, mark: Stroke, points_per_m: float, order: int) -> None:
    if isinstance(mark, Lines):
        lines = [np.vstack([line, line[:1]]) if mark.is_closed else line for line in mark.lines]
        axes.add_collection(
            LineCollection(
                lines, zorder=order, joinstyle='miter', **_stroke(mark.pen, points_per_m)
            ),
            autolim=False,
        )
    elif isinstance(mark, Arcs):
        style = _stroke(mark.pen, points_per_m)
        outline = Outline.make_compound_path(*_arc_outlines(mark))
        axes.add_artist(
            PathPatch(
                outline,
                facecolor='none',
                edgecolor=style['colors'],
                linewidth=style['linewidths'],
                linestyle=style['linestyles'],
                zorder=order,
            )
        )
    elif isinstance(mark, Area):
        outline = Outline.make_compound_path(*(_closed(ring) for ring in mark.rings))
        axes.add_artist(PathPatch(outline, facecolor=mark.colour, linewidth=0.0, zorder=order))
    else:
        _letter(axes, mark, points_per_m, order)


def _stroke(pen: Pen, points_per_m: float) -> dict[str, object]:
    dashes = tuple(length * points_per_m for length in pen.dashes_m)
    return {
        'colors': pen.colour,
        'linewidths': pen.width_m * points_per_m,
        'linestyles': (0.0, dashes) if dashes else 'solid',
    }


def _arc_outlines(arcs: Arcs) -> list[Outline]:
    return [
        _scaled(Outline.arc(*np.degrees(span).tolist()), radius, centre)
        for centre, radius, span in zip(arcs.centre, arcs.radius, arcs.span, strict=True)
    ]


def _scaled(outline: Outline, radius: float, centre: Array) -> Outline:
    return Outline(np.asarray(outline.vertices) * radius + centre, outline.codes)


def _closed(ring: Array) -> Outline:
    return Outline(np.vstack([ring, ring[:1]]), closed=True)


def _letter(axes: Axes, mark: Letters, points_per_m: float, order: int) -> None:
    font = FontProperties(family=mark.font, weight='bold' if mark.is_bold else 'normal')
    axes.text(
        *mark.xy,
        mark.text,
        fontproperties=font,
        fontsize=mark.height_m * points_per_m / CAPITAL_SHARE,
        color=mark.colour,
        rotation=float(np.degrees(mark.angle_rad)),
        rotation_mode='anchor',
        horizontalalignment=mark.align,
        verticalalignment='center_baseline',
        parse_math=False,
        zorder=order,
    )
