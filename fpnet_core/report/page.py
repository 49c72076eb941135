# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From figures and values to one HTML file, everything it needs inside."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs


def write_page(path: Path, template: str, figures: Mapping[str, go.Figure], **values: Any) -> None:
    """
    Render a template of this package with its figures and values to ``path``.

    The template gets ``figures`` as JSON by name, ``plotly`` as the source of the library, and
    ``version``; text is escaped.
    """
    environment = Environment(
        loader=PackageLoader('fpnet_core.report'),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    page = environment.get_template(template).render(
        figures={name: _json(figure) for name, figure in figures.items()},
        # The library's source holds no closing script tag; Markup keeps it as it is.
        plotly=Markup(get_plotlyjs()),  # noqa: S704
        version=_version(),
        **values,
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page, encoding='utf-8')


def _json(figure: go.Figure) -> Markup:
    """Return a figure as JSON that no script tag ends early."""
    text: str = figure.to_json()
    escaped = text.replace('<', '\\u003c').replace('>', '\\u003e').replace('&', '\\u0026')
    return Markup(escaped)  # noqa: S704


def _version() -> str:
    try:
        return version('fpnet_ros')
    except PackageNotFoundError:  # run from a checkout
        return ''
