# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Differences as GeoJSON (RFC 7946) with coordinates in metres of the drawing's frame."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fpnet_core.differences.found import Difference, Differences

_DIGITS = 3  # numerical: millimetres


def as_geojson(found: Differences) -> dict[str, Any]:
    """
    Return a feature collection: one line per difference with kind, confidence and length.

    GeoJSON defaults to longitude and latitude; ``frame`` and ``units`` state the actual ones.
    """
    return {
        'type': 'FeatureCollection',
        'frame': found.grid.frame,
        'units': 'm',
        'features': [_feature(piece) for piece in found.pieces],
    }


def write_geojson(path: Path, found: Differences) -> None:
    """Write differences as GeoJSON; the parent folder is created."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(as_geojson(found), indent=2, allow_nan=False)
    path.write_text(text + '\n', encoding='utf-8')


def _feature(piece: Difference) -> dict[str, Any]:
    return {
        'type': 'Feature',
        'geometry': {
            'type': 'LineString',
            'coordinates': [[round(float(v), _DIGITS) for v in xy] for xy in piece.ends],
        },
        'properties': {
            'kind': piece.kind.value,
            'confidence': round(piece.confidence, _DIGITS),
            'length_m': round(piece.length_m, _DIGITS),
        },
    }
