# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reader of IFC: a storey of a building model, cut one metre above its floor.

Walls, columns, curtain walls and windows are cut; doors are left open. Spaces, doors and windows
are taken from the file as stated. The scale is true. Needs IfcOpenShell, the optional
extra ``ifc``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fpnet_core.drawings.formats.ifc_elements import doors, spaces, windows
from fpnet_core.drawings.formats.ifc_sections import loops, section, triangles
from fpnet_core.drawings.formats.messages import detail_of
from fpnet_core.drawings.formats.pages import (
    BLACK,
    PageBuilder,
    Paint,
    Ring,
    UnitKind,
    VectorPage,
)
from fpnet_core.drawings.model import FloorplanModel, ModelStorey, ModelWall
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError

CUT_M = 1.003
"""
Height of the cut above the floor [m]; not round, as sills and beams end at round heights. Chosen.
"""

MAX_BYTES = 200 * 2**20  # numerical: largest file

_SOLID = ('IfcWall', 'IfcColumn', 'IfcPlate', 'IfcMember', 'IfcCurtainWall', 'IfcWindow')
_SHAPES = 4_000  # numerical: largest number of elements for which other storeys are cut, too
_LAYERS = {'IfcWindow': 'windows', 'IfcPlate': 'windows', 'IfcColumn': 'columns'}


def load_libraries() -> None:
    """
    Import the libraries of this reader before the process is restricted.

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
    walls = []
    for element, rings in _cuts(model, storey, _settings(), floor_m + CUT_M):
        layer = _LAYERS.get(element.is_a(), 'walls')
        builder.add(rings, Paint(BLACK, is_even_odd=True, layer=layer))
        walls.append(ModelWall(tuple(ring.points for ring in rings), source='IFC'))
    if not builder.paths:
        raise MapFormatError(
            f'{path.name} has no walls 1 m above storey {number + 1}; choose another one of '
            f'{len(storeys)} with --page'
        )
    builder.notes.append(f'storey {number + 1} of {len(storeys)} from below: {_named(storey)}')
    page = builder.finish(is_y_up=True, unit_m=1.0, unit_kind=UnitKind.TRUE)
    return replace(page, model=_model(model, storeys, number, walls))


def _open(path: Path) -> Any:
    import ifcopenshell

    if path.stat().st_size > MAX_BYTES:
        raise MapFormatError(
            f'{path.name} is too large: expected at most {MAX_BYTES // 2**20} MB of IFC; export '
            'one storey'
        )
    try:
        model = ifcopenshell.open(str(path))
    except Exception as error:  # IfcOpenShell raises many types on damaged files
        raise MapFormatError(
            f'{path.name} is a damaged IFC file ({detail_of(error)}); export it again'
        ) from None
    return model


def _storeys(model: Any, name: str) -> list[tuple[float, Any]]:
    """Return the storeys with the heights of their floors [m], lowest first."""
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

    within = sorted(elements.get_decomposition(storey), key=lambda element: element.id())
    return [e for e in within if any(e.is_a(kind) for kind in kinds)]


def _cuts(
    model: Any, storey: Any, settings: Any, height_m: float
) -> Iterator[tuple[Any, list[Ring]]]:
    """Yield the section of each element, including those of other storeys that reach the cut."""
    chosen = {element.id(): element for element in _elements(storey, _SOLID)}
    others = [element for kind in _SOLID for element in model.by_type(kind)]
    if len(others) <= _SHAPES:
        chosen.update({element.id(): element for element in others})
    for element in chosen.values():
        body = triangles(element, settings)
        rings = loops(section(*body, height_m)) if body is not None else []
        if rings:
            yield element, rings


def _model(
    model: Any, storeys: list[tuple[float, Any]], number: int, walls: list[ModelWall]
) -> FloorplanModel:
    """Return the stated elements of a storey, with the walls that were cut."""
    from ifcopenshell.util import unit as units

    settings, (floor_m, storey) = _settings(), storeys[number]
    unit_m = float(units.calculate_unit_scale(model))
    return FloorplanModel(
        walls=tuple(walls),
        doors=tuple(doors(_elements(storey, ('IfcDoor',)), settings, unit_m)),
        windows=tuple(windows(_elements(storey, ('IfcWindow',)), settings, unit_m)),
        rooms=tuple(spaces(_elements(storey, ('IfcSpace',)), model, settings, floor_m + CUT_M)),
        storeys=tuple(ModelStorey(_named(each), height) for height, each in storeys),
        storey=number,
    )


def _settings() -> Any:
    import ifcopenshell.geom

    settings = ifcopenshell.geom.settings()
    settings.set('use-world-coords', True)
    return settings


def _named(storey: Any) -> str:
    return str(storey.Name or '').strip() or 'unnamed'
