# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
IFC: a storey of a building model, cut a metre above its floor.

Walls, columns, curtain walls and windows are cut; doors are left open. Lengths are true. Needs
IfcOpenShell, which is the optional extra ``ifc``.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from fpnet_core.drawings.formats.messages import detail_of
from fpnet_core.drawings.formats.pages import (
    BLACK,
    Array,
    PageBuilder,
    Paint,
    Ring,
    UnitKind,
    VectorPage,
)
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError

CUT_M = 1.003
"""
Height of the cut above the floor [m]; not a round figure, at which sills and beams end. Chosen.
"""

MAX_BYTES = 200 * 2**20  # numerical

_SOLID = ('IfcWall', 'IfcColumn', 'IfcPlate', 'IfcMember', 'IfcCurtainWall', 'IfcWindow')
_SHAPES = 4_000  # numerical: elements that are looked at beyond those of the storey itself
_JOIN_M = 1e-4  # numerical: ends of cut lines so close are one
_LAYERS = {'IfcWindow': 'windows', 'IfcPlate': 'windows', 'IfcColumn': 'columns'}


def load_libraries() -> None:
    """
    Import what reading takes, before the process may do no more than read.

    Raises
    ------
    MapFormatError
        If IfcOpenShell is not installed.
    """
    try:
        import ifcopenshell.geom
        import ifcopenshell.util.element
        import ifcopenshell.util.placement
        import ifcopenshell.util.unit  # noqa: F401
    except ImportError as error:
        raise MapFormatError(
            f'IFC files need IfcOpenShell ({error}): install it with pip install '
            "'fpnet_ros[ifc]', or export the storey as DXF"
        ) from None


def read_ifc(path: Path, options: ReadOptions) -> VectorPage:
    """
    Return a storey of a building: ``options.page`` from below, else the one with most walls.

    Raises
    ------
    MapFormatError
        If the file is damaged or too large, or lacks the storey or any walls.
    """
    model = _open(path)
    storeys = _storeys(model, path.name)
    number = _number(storeys, options, path.name)
    floor_m, storey = storeys[number]
    builder = PageBuilder(path.name)
    for element, loops in _cuts(model, storey, floor_m + CUT_M):
        layer = _LAYERS.get(element.is_a(), 'walls')
        builder.add(loops, Paint(BLACK, is_even_odd=True, layer=layer))
    if not builder.paths:
        raise MapFormatError(
            f'{path.name} has no walls a metre above storey {number + 1}; choose another one of '
            f'{len(storeys)} with --page'
        )
    name = str(storey.Name or '').strip() or 'unnamed'
    builder.notes.append(f'storey {number + 1} of {len(storeys)} from below: {name}')
    return builder.finish(is_y_up=True, unit_m=1.0, unit_kind=UnitKind.TRUE)


def _open(path: Path) -> Any:
    import ifcopenshell

    if path.stat().st_size > MAX_BYTES:
        raise MapFormatError(
            f'{path.name} is too large: expected at most {MAX_BYTES // 2**20} MB of IFC; export '
            'one storey'
        )
    try:
        model = ifcopenshell.open(str(path))
    except Exception as error:  # IfcOpenShell raises many kinds on damaged files
        raise MapFormatError(
            f'{path.name} is a damaged IFC file ({detail_of(error)}); export it again'
        ) from None
    return model


def _storeys(model: Any, name: str) -> list[tuple[float, Any]]:
    """Return the storeys with the heights of their floors [m], from below."""
    from ifcopenshell.util import placement
    from ifcopenshell.util import unit as units

    found = []
    try:
        unit_m = float(units.calculate_unit_scale(model))
        for storey in model.by_type('IfcBuildingStorey'):
            height = float(storey.Elevation or 0.0)
            if storey.ObjectPlacement is not None:
                height = float(placement.get_local_placement(storey.ObjectPlacement)[2, 3])
            found.append((height * unit_m, storey))
    except Exception as error:
        raise MapFormatError(
            f'{name} is a damaged IFC file ({detail_of(error)}); export it again'
        ) from None
    if not found:
        raise MapFormatError(f'{name} has no storeys: expected a building; export it as IFC 4')
    return sorted(found, key=lambda pair: pair[0])


def _number(storeys: list[tuple[float, Any]], options: ReadOptions, name: str) -> int:
    if options.page is not None:
        if not 1 <= options.page <= len(storeys):
            raise MapFormatError(
                f'{name} has {len(storeys)} storeys; there is no storey {options.page}'
            )
        return options.page - 1
    return int(
        np.argmax([len(_elements(storey, ('IfcWall', 'IfcDoor'))) for _, storey in storeys])
    )


def _elements(storey: Any, kinds: tuple[str, ...]) -> list[Any]:
    import ifcopenshell.util.element as elements

    return [e for e in elements.get_decomposition(storey) if any(e.is_a(kind) for kind in kinds)]


def _cuts(model: Any, storey: Any, height_m: float) -> Iterator[tuple[Any, list[Ring]]]:
    """Yield what the cut leaves of each element, those of other storeys that reach it as well."""
    import ifcopenshell.geom

    settings = ifcopenshell.geom.settings()
    settings.set('use-world-coords', True)
    chosen = {element.id(): element for element in _elements(storey, _SOLID)}
    others = [element for kind in _SOLID for element in model.by_type(kind)]
    if len(others) <= _SHAPES:
        chosen.update({element.id(): element for element in others})
    for element in chosen.values():
        if element.Representation is None:
            continue
        shape: Any = None
        with suppress(Exception):  # an element without a proper body; the others may have one
            shape = ifcopenshell.geom.create_shape(settings, element)
        if shape is None:
            continue
        vertices = np.array(shape.geometry.verts, dtype=np.float64).reshape(-1, 3)
        faces = np.array(shape.geometry.faces, dtype=np.int64).reshape(-1, 3)
        loops = _loops(_section(vertices, faces, height_m))
        if loops:
            yield element, loops


def _section(vertices: Array, faces: Any, height: float) -> Array:
    """Return the pieces ``(N, 2, 2)`` at which the triangles of a body cross a height."""
    corners = vertices[faces]
    above = corners[:, :, 2] > height
    corners, above = corners[(crosses := above.any(axis=1) != above.all(axis=1))], above[crosses]
    if not len(corners):
        return np.empty((0, 2, 2))
    # Each crossing triangle has one corner alone on its side of the cut.
    alone = np.argmax(above == (above.sum(axis=1) == 1)[:, None], axis=1)
    rows = np.arange(len(corners))
    tip = corners[rows, alone]
    ends = [corners[rows, (alone + k) % 3] for k in (1, 2)]
    share = [(height - tip[:, 2]) / (end[:, 2] - tip[:, 2]) for end in ends]
    pieces = [tip + s[:, None] * (end - tip) for s, end in zip(share, ends, strict=True)]
    return np.stack(pieces, axis=1)[:, :, :2]


def _loops(pieces: Array) -> list[Ring]:
    """Return rings joined from pieces; pieces that lead nowhere are left out."""
    keys = [tuple(map(tuple, np.rint(piece / _JOIN_M).astype(int).tolist())) for piece in pieces]
    joints: dict[tuple[int, ...], list[int]] = {}
    for number, ends in enumerate(keys):
        if ends[0] != ends[1]:
            for end in ends:
                joints.setdefault(end, []).append(number)
    used: set[int] = set()
    rings = []
    for number, ends in enumerate(keys):
        if number not in used and ends[0] != ends[1]:
            points = _followed(number, keys, joints, used)
            if points[0] == points[-1] and len(points) > 3:
                rings.append(Ring(np.array(points[:-1]) * _JOIN_M, is_closed=True))
    return rings


def _followed(
    number: int,
    keys: list[tuple[tuple[int, ...], ...]],
    joints: dict[tuple[int, ...], list[int]],
    used: set[int],
) -> list[tuple[int, ...]]:
    """Return the points of a chain of unused pieces until it closes or ends."""
    points = list(keys[number])
    used.add(number)
    while points[-1] != points[0]:
        following = next((k for k in joints[points[-1]] if k not in used), None)
        if following is None:
            break
        used.add(following)
        first, second = keys[following]
        points.append(second if first == points[-1] else first)
    return points
