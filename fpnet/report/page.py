# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Self-contained HTML pages from figures and values."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from functools import cache
import gzip
from importlib.metadata import PackageNotFoundError, version
import json
from pathlib import Path
import re
from typing import Any
import zlib

from jinja2 import Environment, PackageLoader, StrictUndefined
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from fpnet_core.errors import FpnetError

_CONTENT = re.compile(r'<script type="text/plain" id="content">([A-Za-z0-9+/=]+)</script>')
_LEVEL = 9  # numerical: of gzip, its best


def write_page(
    path: Path,
    template: str,
    figures: Mapping[str, go.Figure],
    data: Mapping[str, Any] | None = None,
    **values: Any,
) -> None:
    """Write a page, see :func:`page_text`, to ``path``; its folder is created."""
    text = page_text(template, figures, data, **values)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding='utf-8')


def page_text(
    template: str,
    figures: Mapping[str, go.Figure | Mapping[str, Any]],
    data: Mapping[str, Any] | None = None,
    **values: Any,
) -> str:
    """
    Render a template of this package with figures, data and values; text is escaped.

    The page's script finds figures by name and ``data``. Both are compressed by :func:`packed`,
    like the plotting library: the page of a one-minute run is small enough to be mailed.
    """
    environment = Environment(
        loader=PackageLoader('fpnet.report'),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    charts = {
        name: json.loads(figure.to_json()) if isinstance(figure, go.Figure) else figure
        for name, figure in figures.items()
    }
    content = json.dumps({'figures': charts, 'data': data or {}}, separators=(',', ':'))
    return environment.get_template(template).render(
        content=packed(content), plotly=_library(), version=_version(), **values
    )


def packed(text: str) -> str:
    """Return a text compressed by gzip, in base64, which contains no markup."""
    return base64.b64encode(gzip.compress(text.encode('utf-8'), _LEVEL, mtime=0)).decode('ascii')


def read_content(report: Path) -> dict[str, Any]:
    """
    Return the content of a report's page: ``figures`` and ``data``.

    Raises
    ------
    FpnetError
        If the file is missing, or not a report of this version.
    """
    try:
        text = report.read_text(encoding='utf-8')
    except (OSError, ValueError) as error:
        raise FpnetError(f'cannot read {report}: {error}; give the folder of a run') from None
    found = _CONTENT.search(text)
    try:
        packed = base64.b64decode(found[1], validate=True) if found else b''
        content: dict[str, Any] = json.loads(gzip.decompress(packed))
        content['figures']['timeline'], content['data']
    except (ValueError, KeyError, TypeError, EOFError, OSError, zlib.error):
        raise FpnetError(
            f'{report} is not a run report of this version; make it again with fpnet localize '
            '--out'
        ) from None
    return content


@cache
def _library() -> str:
    return packed(get_plotlyjs())


def _version() -> str:
    try:
        return version('fpnet_ros')
    except PackageNotFoundError:  # run from a checkout
        return ''
