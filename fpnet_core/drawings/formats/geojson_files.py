# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Loading of JSON from a GeoJSON file, a folder of them, or a ZIP, with limits."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
import zipfile

from fpnet_core.drawings.formats.messages import detail_of
from fpnet_core.errors import MapFormatError
from fpnet_core.plain_files import regular

MAX_BYTES = 64 * 2**20
"""Numerical: of all JSON together, after unpacking."""

_SUFFIXES = ('.geojson', '.json')
_MAX_FILES = 200  # numerical: in a folder or a ZIP; IMDF has about twenty


def feature_files(path: Path) -> list[tuple[str, Any]]:
    """
    Return the lower-case stem and the JSON values of each file.

    Raises
    ------
    MapFormatError
        If one of them is damaged, or all together are too large.
    """
    if path.is_dir():
        names = sorted(each for each in path.iterdir() if each.suffix.lower() in _SUFFIXES)
        left, found = MAX_BYTES, []
        for each in names[:_MAX_FILES]:
            with regular(each).open('rb') as stream:
                data = stream.read(left + 1)
            left -= len(data)
            found.append((each.stem.lower(), _parsed(data, left, f'{path.name}/{each.name}')))
        return found
    with path.open('rb') as stream:
        if stream.read(2) != b'PK':
            stream.seek(0)
            data = stream.read(MAX_BYTES + 1)
            return [(path.stem.lower(), _parsed(data, MAX_BYTES - len(data), path.name))]
    return _unpacked(path)


def _unpacked(path: Path) -> list[tuple[str, Any]]:
    left, found = MAX_BYTES, []
    try:
        with zipfile.ZipFile(path) as archive:
            names = [name for name in archive.namelist() if name.lower().endswith(_SUFFIXES)]
            for name in names[:_MAX_FILES]:
                with archive.open(name) as stream:
                    data = stream.read(left + 1)
                left -= len(data)
                found.append((Path(name).stem.lower(), _parsed(data, left, path.name)))
    except MapFormatError:
        raise
    except Exception as error:  # damaged and encrypted archives raise many types
        raise MapFormatError(
            f'{path.name} is a damaged archive ({detail_of(error)}); pack it again'
        ) from None
    return found


def _parsed(data: bytes, left: int, name: str) -> Any:
    if left < 0:
        raise MapFormatError(
            f'{name} is too large: expected at most {MAX_BYTES // 2**20} MB of GeoJSON; export '
            'one building'
        )
    try:
        return json.loads(data.decode('utf-8-sig'))
    except (ValueError, RecursionError) as error:
        raise MapFormatError(
            f'{name} is a damaged GeoJSON ({detail_of(error)}); export it again'
        ) from None
