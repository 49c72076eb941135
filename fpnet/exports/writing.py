# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Export of a floorplan model in the format given by the file's suffix."""

from __future__ import annotations

from pathlib import Path

from fpnet_core.drawings.model import FloorplanModel
from fpnet_core.errors import ConfigError

SUFFIXES = ('.geojson', '.zip', '.building.yaml', '.dxf', '.svg')
"""Suffixes of exported files: GeoJSON, IMDF, Open-RMF, DXF, SVG."""


def export_suffix(path: Path) -> str:
    """
    Return the element of ``SUFFIXES`` that a file name ends with.

    Raises
    ------
    ConfigError
        If it ends with none of them.
    """
    for suffix in SUFFIXES:
        if path.name.lower().endswith(suffix):
            return suffix
    raise ConfigError(f'--export {path}: expected a name that ends in {", ".join(SUFFIXES)}')


def write_model(model: FloorplanModel, path: Path | str, name: str = 'floorplan') -> None:
    """
    Write rooms, doors, windows and walls of a model to a file; create its folder.

    Raises
    ------
    ConfigError
        If the suffix is none of ``SUFFIXES``, or the format's library is not installed.
    """
    path = Path(path)
    suffix = export_suffix(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    if suffix in ('.geojson', '.zip'):
        from fpnet.exports.imdf import write_geojson, write_imdf

        (write_imdf if suffix == '.zip' else write_geojson)(model, path, name)
    elif suffix == '.building.yaml':
        from fpnet.exports.rmf import write_rmf

        write_rmf(model, path, name)
    elif suffix == '.dxf':
        from fpnet.exports.lines import write_dxf

        write_dxf(model, path)
    else:
        from fpnet.exports.lines import write_svg

        write_svg(model, path, name)
