# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Files of a parsed drawing: a map_server map and a JSON record beside it.

The map states its resolution, but neither the uncertainty of the scale nor the transform from the
user's pixels. The JSON file of the same name holds both and is read back with the map.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.room_names import room_names
from fpnet_core.drawings.types import DrawingScale, Reading, RoomName, ScaleSource
from fpnet_core.errors import MapFormatError
from fpnet_core.io.maps import write_map

MAP_FORMAT = 'map_server'
"""Format of a :class:`fpnet_core.drawings.types.Drawing` that is a map_server map."""

_VERSION = 1  # given: of the record
_MARK = 'fpnet_plan'  # distinguishes records from other JSON files beside a map
_MAX_BYTES = 1_000_000  # numerical: longer files are no records
_AFFINE = 1e-9  # numerical: tolerance of the last row (0, 0, 1) of an affine map
_SAME = 1e-6  # numerical: relative error of a number after writing and reading


def write_plan(reading: Reading, yaml_path: Path | str) -> Path:
    """Write the map with its image and its record; return the path of the record."""
    yaml_path = Path(yaml_path)
    write_map(reading.grid, yaml_path)
    record = record_path(yaml_path)
    text = json.dumps(as_json(reading), indent=2, allow_nan=False)
    record.write_text(text + '\n', encoding='utf-8')
    return record


def record_path(yaml_path: Path) -> Path:
    """Return the path of a map's record: beside it, as JSON."""
    return yaml_path.with_suffix('.json')


def picture_path(yaml_path: Path) -> Path:
    """Return the path of the picture that shows the parse of a map: beside it."""
    return yaml_path.with_name(f'{yaml_path.stem}_reading.png')


def is_affine(H: NDArray[np.float64]) -> bool:
    """Return whether a homography (3, 3) is affine."""
    return bool(np.allclose(H[2] / H[2, 2], (0.0, 0.0, 1.0), atol=_AFFINE))


def as_json(reading: Reading) -> dict[str, Any]:
    """Return a parse result without its map as JSON values."""
    width, height = reading.drawing.size
    return {
        _MARK: _VERSION,
        'drawing': reading.drawing.name,
        'format': reading.drawing.format,
        'pixels': [width, height],
        'H_plan_image': reading.H_plan_image.tolist(),
        'A_image_file': reading.drawing.A_pixel_image.tolist(),
        'cell_m': reading.grid.resolution,
        'scale': scale_as_json(reading.scale),
        'how': reading.how,
        'storeys': [list(map(int, box)) for box in reading.storeys],
        'notes': list(reading.notes),
        'doubts': list(reading.doubts),
        'accepted': reading.accepted or None,
        'doubtful': [
            {'what': each.what, 'box': list(map(int, each.box))} for each in reading.doubtful
        ],
        'room_names': [{'name': each.name, 'xy': list(each.xy)} for each in room_names(reading)],
    }


def scale_as_json(scale: DrawingScale) -> dict[str, Any]:
    """Return a scale as JSON values: metres per pixel, interval, source and reason."""
    return {
        'metres_per_pixel': float(scale.resolution_m),
        'interval': [float(scale.low_m), float(scale.high_m)],
        'source': scale.source.value,
        'why': scale.why,
    }


@dataclass(frozen=True)
class PlanRecord:
    """
    Record of a map that was parsed from a drawing.

    ``scale`` is that of the map's own pixels; ``doubts`` (parser warnings), ``accepted`` and
    ``names`` are as in :class:`fpnet_core.drawings.types.Reading`.
    """

    scale: DrawingScale
    doubts: tuple[str, ...] = ()
    accepted: str = ''
    names: tuple[RoomName, ...] = ()


def recorded(yaml_path: Path | str, cell_m: float) -> PlanRecord | None:
    """
    Return the record beside a map whose cells are ``cell_m``.

    None if there is no record, or if the map's resolution was changed after it was written.

    Raises
    ------
    MapFormatError
        If the record is damaged.
    """
    path = record_path(Path(yaml_path))
    values = _read(path)
    if values is None:
        return None
    try:
        written_m, scale = float(values['cell_m']), _scale_of(values['scale'])
        doubts = tuple(str(doubt) for doubt in values['doubts'])
        accepted = str(values.get('accepted') or '')
        names = tuple(_room_of(each) for each in values.get('room_names', ()))
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise MapFormatError(
            f'{path} is a damaged record of a floorplan ({error}); remove it, or run fpnet plan '
            'again'
        ) from None
    if not math.isclose(written_m, cell_m, rel_tol=_SAME):
        return None
    cells = cell_m / scale.resolution_m
    scale = replace(
        scale, resolution_m=cell_m, low_m=scale.low_m * cells, high_m=scale.high_m * cells
    )
    return PlanRecord(scale, doubts, accepted, names)


def _read(path: Path) -> dict[str, Any] | None:
    """Return the values of a record; None if there is none."""
    try:
        if not path.is_file() or path.stat().st_size > _MAX_BYTES:
            return None
        values = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return None
    return values if isinstance(values, dict) and _MARK in values else None


def _room_of(values: dict[str, Any]) -> RoomName:
    x, y = map(float, values['xy'])
    if not (math.isfinite(x) and math.isfinite(y)):
        raise ValueError(f'room_names: xy must be finite, got {x:g}, {y:g}')
    return RoomName(str(values['name']), (x, y))


def _scale_of(values: dict[str, Any]) -> DrawingScale:
    low, high = map(float, values['interval'])
    metres = float(values['metres_per_pixel'])
    if not 0.0 < low <= metres <= high < math.inf:
        raise ValueError(f'scale: {low:g} <= {metres:g} <= {high:g} m per pixel does not hold')
    return DrawingScale(metres, low, high, ScaleSource(values['source']), str(values['why']))
