# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Figures to draw on, figures saved as images, and HTML for notebooks."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from html import escape
import io
from pathlib import Path
import reprlib
from typing import TYPE_CHECKING, TypeVar

from fpnet_core.errors import FpnetError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Given = TypeVar('Given')

_SIZE_INCHES = (8.0, 8.0)  # chosen
DPI = 110  # chosen: of most plots
_BAR_M = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)  # given: round lengths
_BAR_SHARE = 0.2  # chosen: of a plot's width, at most
_NOTEBOOK_DPI = 80  # chosen: fits the width of a page


def scale_bar_m(width: float) -> float:
    """Return the length [m] of a scale bar: the longest round one below a fifth of a width [m]."""
    fitting = [metres for metres in _BAR_M if metres <= _BAR_SHARE * width]
    return fitting[-1] if fitting else _BAR_M[0]


def figure_of(figure: Figure | None, size_inches: tuple[float, float] = _SIZE_INCHES) -> Figure:
    """Return ``figure``, or a new pyplot figure, which scripts show with ``pyplot.show()``."""
    if figure is not None:
        from matplotlib.figure import FigureBase

        return _checked(figure, FigureBase, 'a matplotlib figure')
    from matplotlib import pyplot

    return pyplot.figure(figsize=size_inches, layout='constrained')


def axes_of(ax: Axes | None) -> Axes:
    """Return ``ax``, or the axes of a new figure."""
    from matplotlib.axes import Axes

    return figure_of(None).add_subplot() if ax is None else _checked(ax, Axes, 'matplotlib axes')


def _checked(given: Given, kind: type, what: str) -> Given:
    if not isinstance(given, kind):
        raise FpnetError(f'plot: expected {what} to draw on, got {reprlib.repr(given)}')
    return given


@contextmanager
def saved_figure(path: Path, size_inches: tuple[float, float], dpi: float) -> Iterator[Figure]:
    """Yield a new figure to draw into, then save it as an image; its folder is created."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size_inches, layout='constrained')
    yield figure
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=dpi)


def html_of(value: object, draw: Callable[[Figure], object] | None) -> str:
    """Return a value's ``repr`` and the figure that ``draw`` fills, as self-contained HTML."""
    said = escape(repr(value))
    if draw is None:
        return f'<p>{said}</p>'
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE_INCHES, layout='constrained')
    draw(figure)
    picture = io.BytesIO()
    figure.savefig(picture, format='png', dpi=_NOTEBOOK_DPI, bbox_inches='tight')
    encoded = base64.b64encode(picture.getvalue()).decode('ascii')
    return f'<p>{said}</p><img src="data:image/png;base64,{encoded}" alt="{said}">'
