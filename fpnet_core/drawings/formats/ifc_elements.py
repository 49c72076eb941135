# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Spaces, doors and windows of an IFC storey, in metres of the file's coordinates."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from fpnet_core.drawings.formats.ifc_sections import Triangles, loops, section, triangles
from fpnet_core.drawings.formats.pages import Array
from fpnet_core.drawings.model import DoorKind, ModelDoor, ModelRoom, ModelWindow, ring_area

_SOURCE = 'IFC'
_DEEPEST_M = 0.8  # physical: thickest wall with a door; voids may be deeper
_WIDTHS_M = (0.3, 12.0)  # physical: widths of doors, gates and windows
_UPRIGHT = 0.5  # numerical: determinant of a placement's horizontal axes; 1 is upright
_LEAST_M2 = 0.2  # numerical: smaller spaces are slivers
_KINDS = (
    ('DOUBLE', DoorKind.DOUBLE), ('SWING', DoorKind.SWING), ('SLIDING', DoorKind.SLIDING),
    ('FOLDING', DoorKind.FOLDING), ('REVOLVING', DoorKind.REVOLVING),
)  # fmt: skip
_AREAS = ('NetFloorArea', 'GrossFloorArea', 'NetArea', 'Area')  # given: names of quantities


def spaces(elements: list[Any], model: Any, settings: Any, height_m: float) -> list[ModelRoom]:
    """Return the rooms of a storey's spaces, cut at a height [m]; outdoor ones are skipped."""
    from ifcopenshell.util import unit as units

    area_unit = 1.0
    with suppress(Exception):  # without an area unit, areas are in square metres
        area_unit = float(units.calculate_unit_scale(model, 'AREAUNIT'))
    rooms = []
    for space in elements:
        kind = str(getattr(space, 'PredefinedType', None) or '')
        outdoors = getattr(space, 'InteriorOrExteriorSpace', None) == 'EXTERNAL'
        if kind == 'EXTERNAL' or outdoors or space.CompositionType == 'COMPLEX':
            continue
        body = triangles(space, settings)
        if body is None:
            continue
        rings = tuple(_cut(body, height_m))
        if rings and abs(ring_area(rings[0])) > _LEAST_M2:
            words = (space.Name, space.LongName)
            name = ' '.join(dict.fromkeys(str(each).strip() for each in words if each))
            rooms.append(
                ModelRoom(rings, name, _area(space, area_unit), kind.lower(), source=_SOURCE)
            )
    return rooms


def _cut(body: Triangles, height_m: float) -> Iterator[Array]:
    """Yield the rings of a space at a height, or at its middle if the height misses it."""
    vertices, faces = body
    rings = loops(section(vertices, faces, height_m))
    if not rings:
        low, high = vertices[:, 2].min(), vertices[:, 2].max()
        rings = loops(section(vertices, faces, 0.5001 * (low + high)))
    points = [ring.points for ring in rings if len(ring.points) > 2]
    yield from sorted(points, key=lambda ring: -abs(ring_area(ring)))


def _area(space: Any, unit: float) -> float | None:
    """Return a space's area [m2] from its quantities; None if they state none."""
    import ifcopenshell.util.element as elements

    with suppress(Exception):  # damaged quantities are ignored
        for quantities in elements.get_psets(space, qtos_only=True).values():
            for name in _AREAS:
                value = float(quantities.get(name) or 0.0) * unit
                if 0.0 < value < np.inf:
                    return value
    return None


def doors(elements: list[Any], settings: Any, unit_m: float) -> list[ModelDoor]:
    """Return the doors among a storey's elements."""
    found = []
    for door in elements:
        placed = _opening(door, settings, unit_m)
        if placed is None:
            continue
        ends, depth, outward = placed
        operation = _operation(door)
        kind = next((kind for word, kind in _KINDS if word in operation), DoorKind.UNKNOWN)
        hinge = None
        if kind is DoorKind.SWING and operation.endswith(('LEFT', 'RIGHT')):
            hinge = int(operation.endswith('RIGHT'))
        width = float(np.hypot(*(ends[1] - ends[0])))
        leaf = None if hinge is None else ends[hinge] + width * outward
        name = str(door.Name or '').strip()
        found.append(ModelDoor(ends, depth, kind, hinge, leaf, name, source=_SOURCE))
    return found


def windows(elements: list[Any], settings: Any, unit_m: float) -> list[ModelWindow]:
    """Return the windows among a storey's elements."""
    placed = [_opening(window, settings, unit_m) for window in elements]
    return [ModelWindow(each[0], each[1], source=_SOURCE) for each in placed if each is not None]


def _operation(door: Any) -> str:
    """Return the operation type of a door element or its type, in upper case."""
    import ifcopenshell.util.element as elements

    with suppress(Exception):  # a damaged type is ignored
        for each in (door, elements.get_type(door)):
            operation = str(getattr(each, 'OperationType', None) or '')
            if operation not in ('', 'NOTDEFINED'):
                return operation.upper()
    return ''


def _opening(element: Any, settings: Any, unit_m: float) -> tuple[Array, float, Array] | None:
    """
    Return the ends (2, 2) [m] of a door or window, its wall's thickness [m], and a direction.

    The direction is the axis of its placement across the wall, to which doors open. None if it
    has no placement or an implausible width.
    """
    from ifcopenshell.util import placement

    if element.ObjectPlacement is None:
        return None
    matrix = np.asarray(placement.get_local_placement(element.ObjectPlacement), dtype=np.float64)
    axes = matrix[:2, :2]
    if not np.isfinite(matrix).all() or abs(np.linalg.det(axes)) < _UPRIGHT:  # it is tilted
        return None
    along, across = axes[:, 0] / np.hypot(*axes[:, 0]), axes[:, 1] / np.hypot(*axes[:, 1])
    box = _box(element, settings, along, across)
    if box is None:
        start = matrix[:2, 3] * unit_m
        width = float(getattr(element, 'OverallWidth', None) or 0.0) * unit_m
        (u0, v0), u1, depth = (start @ along, start @ across), start @ along + width, 0.0
    else:
        (u0, v), (u1, w) = box
        v0, depth = 0.5 * (v + w), min(w - v, _DEEPEST_M)
    if not _WIDTHS_M[0] < u1 - u0 < _WIDTHS_M[1]:
        return None
    ends = np.array([u0 * along + v0 * across, u1 * along + v0 * across])
    return ends, float(depth), across


def _box(element: Any, settings: Any, along: Array, across: Array) -> Array | None:
    """Return the lower and upper bounds (2, 2) of an element's void along two directions."""
    filled = [each.RelatingOpeningElement for each in getattr(element, 'FillsVoids', None) or ()]
    for each in (*filled, element):
        body = triangles(each, settings)
        if body is not None:
            places = body[0][:, :2] @ np.column_stack([along, across])
            return np.array([places.min(axis=0), places.max(axis=0)])
    return None
