# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
DXF: the model space with its blocks exploded, layers that are on, and true units.

External references, images and underlays are never followed. Colours are not kept: on a screen of
a CAD program they tell layers apart, and layers have names.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
import math
from pathlib import Path
from typing import Any

import numpy as np

from fpnet_core.drawings.layers import Role, layer_role
from fpnet_core.drawings.messages import detail_of
from fpnet_core.drawings.pages import (
    BLACK,
    Array,
    PageBuilder,
    Paint,
    Ring,
    UnitKind,
    VectorPage,
)
from fpnet_core.drawings.types import Label, ReadOptions
from fpnet_core.errors import MapFormatError

MAX_ENTITIES = 300_000
"""After blocks are exploded; a block that holds itself many times over multiplies."""

_MAX_DEPTH = 12  # blocks in blocks
_UNITS_M = {1: 0.0254, 2: 0.3048, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 10: 0.9144, 14: 0.1, 21:
            1200 / 3937}  # fmt: skip  # $INSUNITS
_CURVE_SHARE = 0.02  # of a curve's size, how far its pieces may be off
_ARC_STEP = np.radians(7.5)
_TEXT_ASPECT = 0.7  # of a letter, width to height
_THIN = 0.7  # of a hatched area [m], the width up to which it is a wall and not a floor
_LEFT_OUT = frozenset({
    'IMAGE', 'PDFUNDERLAY', 'DWFUNDERLAY', 'DGNUNDERLAY', 'OLE2FRAME', 'OLEFRAME', 'WIPEOUT',
})  # fmt: skip
_POLYGONS = frozenset({'SOLID', 'TRACE', '3DFACE'})


@dataclass
class _Reader:
    """Walks through the entities of a document."""

    builder: PageBuilder
    hidden: frozenset[str]
    dashed: dict[str, bool]
    count: int = 0
    damaged: int = 0
    left_out: dict[str, int] = field(default_factory=dict)


def load_libraries() -> None:
    """Import what reading takes, before the process may do no more than read."""
    import ezdxf.path
    import ezdxf.recover  # noqa: F401


def read_dxf(path: Path, options: ReadOptions) -> VectorPage:
    """
    Return the model space of a DXF file.

    Raises
    ------
    MapFormatError
        If the file is damaged beyond recovery or too large.
    """
    document = _load(path)
    layers = {layer.dxf.name.casefold(): layer for layer in document.layers}
    wanted = {layer.casefold() for layer in options.layers}
    hidden = frozenset(
        name for name, layer in layers.items()
        if (layer.is_off() or layer.is_frozen()) and name not in wanted
    )  # fmt: skip
    dashed = {name: _is_dash(layer.dxf.linetype) for name, layer in layers.items()}
    _refuse_growth(document, path.name)
    reader = _Reader(PageBuilder(path.name), hidden, dashed)
    for entity, layer in _entities(reader, document.modelspace(), '0', '', 0):
        _add(reader, entity, layer)
    notes = reader.builder.notes
    if hidden:
        notes.append(f'{len(hidden)} layers are frozen or off and left out')
    if reader.damaged:
        notes.append(f'{reader.damaged} damaged entities are left out')
    for kind, number in reader.left_out.items():
        notes.append(f'{number} x {kind} left out: references to other files are never followed')
    unit = _UNITS_M.get(int(document.header.get('$INSUNITS', 0)))
    return reader.builder.finish(is_y_up=True, unit_m=unit, unit_kind=UnitKind.CLAIMED)


def _load(path: Path) -> Any:
    from ezdxf import filemanagement, recover

    with suppress(Exception):  # damaged: the slow and tolerant reader may manage
        return filemanagement.readfile(path)
    try:
        document, _ = recover.readfile(path)
    except Exception as error:  # ezdxf raises many kinds on damaged files
        raise MapFormatError(
            f'{path.name} is a damaged DXF file ({detail_of(error)}); save it again as DXF 2010 '
            'or later'
        ) from None
    return document


def _refuse_growth(document: Any, name: str) -> None:
    """Refuse blocks that hold each other so often that exploding them would not end."""
    sizes: dict[str, int] = {}

    def size(container: Any, depth: int) -> int:
        total = 0
        for entity in container:
            total += 1
            if entity.dxftype() == 'INSERT' and depth < _MAX_DEPTH:
                total += max(int(entity.mcount), 1) * block_size(str(entity.dxf.name), depth + 1)
            if total > MAX_ENTITIES:
                break
        return total

    def block_size(key: str, depth: int) -> int:
        if key not in sizes:
            sizes[key] = MAX_ENTITIES + 1  # while it is being counted: a block within itself
            block = document.blocks.get(key)
            sizes[key] = size(block, depth) if block is not None else 0
        return sizes[key]

    if size(document.modelspace(), 0) > MAX_ENTITIES:
        raise MapFormatError(_too_large(name))


def _too_large(name: str) -> str:
    return (
        f'{name} is too large: expected at most {MAX_ENTITIES:,} entities after its blocks are '
        'exploded; save only the storey that is needed'
    )


def _entities(
    reader: _Reader, container: Any, parent: str, block: str, depth: int
) -> Iterator[tuple[Any, str]]:
    """Yield what is visible in a container, blocks exploded, with the layer that it counts to."""
    for entity in container:
        reader.count += 1
        if reader.count > MAX_ENTITIES:
            raise MapFormatError(_too_large(reader.builder.what))
        own = str(entity.dxf.get('layer', '0'))
        layer = parent if own == '0' and depth else own
        if layer.casefold() in reader.hidden or entity.dxf.get('invisible', 0):
            continue
        kind = entity.dxftype()
        if kind in _LEFT_OUT:
            if kind != 'WIPEOUT':
                reader.left_out[kind] = reader.left_out.get(kind, 0) + 1
        elif kind == 'INSERT':
            yield from _insert(reader, entity, layer, block, depth)
        elif kind == 'DIMENSION':
            yield from _dimension(reader, entity, layer)
        else:
            yield entity, _named(layer, block)


def _named(layer: str, block: str) -> str:
    """Return the layer, with the block's name where the layer's says nothing and that does."""
    is_telling = block and layer_role(layer) is Role.UNKNOWN and layer_role(block) != Role.UNKNOWN
    return f'{layer}: {block}' if is_telling else layer


def _insert(
    reader: _Reader, insert: Any, layer: str, block: str, depth: int
) -> Iterator[tuple[Any, str]]:
    definition = insert.block()
    if definition is None or depth >= _MAX_DEPTH:
        return
    if definition.block is not None and definition.block.is_xref:
        reader.left_out['XREF'] = reader.left_out.get('XREF', 0) + 1
        return
    name = block if block and layer_role(block) != Role.UNKNOWN else str(insert.dxf.name)
    copies = insert.multi_insert() if insert.mcount > 1 else [insert]
    for copy in copies:
        parts = _tolerant(copy.virtual_entities(skipped_entity_callback=_ignore))
        yield from _entities(reader, parts, layer, name, depth + 1)
        for attribute in copy.attribs:
            yield attribute, layer


def _ignore(entity: Any, reason: str) -> None:
    """Leave out what cannot be exploded, as ezdxf does."""


def _dimension(reader: _Reader, dimension: Any, layer: str) -> Iterator[tuple[Any, str]]:
    for part in _tolerant(dimension.virtual_entities()):
        reader.count += 1
        yield part, f'{layer}: dimensions'


def _tolerant(parts: Iterator[Any]) -> Iterator[Any]:
    """Yield parts until one of them is damaged."""
    try:
        yield from parts
    except MapFormatError:
        raise
    except Exception:  # ezdxf raises many kinds on damaged entities
        return


def _add(reader: _Reader, entity: Any, layer: str) -> None:
    kind = entity.dxftype()
    try:
        if kind in ('TEXT', 'MTEXT', 'ATTRIB'):
            label = _label(entity, kind)
            if label is not None:
                reader.builder.labels.append(label)
            return
        paint = Paint(
            stroke=BLACK,
            layer=layer,
            is_dashed=_entity_is_dashed(reader, entity),
            is_even_odd=True,
        )
        if kind in ('HATCH', 'MPOLYGON'):
            _add_hatch(reader, entity, layer)
        elif kind in _POLYGONS:
            _add_polygon(reader, entity, kind, paint)
        else:
            rings, width = _rings(entity, kind)
            reader.builder.add(rings, replace(paint, width=width))
    except MapFormatError:
        raise
    except Exception:  # a damaged entity: the others may be good
        reader.damaged += 1


def _rings(entity: Any, kind: str) -> tuple[list[Ring], float]:
    """Return an entity's outline and its width."""
    if kind == 'POLYLINE':
        return _old_polyline(entity)
    if kind == 'LWPOLYLINE':
        return [_polyline(entity)], _width(entity)
    if kind == 'MLINE':
        parts = entity.virtual_entities()
        return [ring for part in parts for ring in _rings(part, part.dxftype())[0]], 0.0
    make = _OUTLINES.get(kind)
    return ([make(entity)] if make else []), 0.0


def _line(entity: Any) -> Ring:
    start, end = entity.dxf.start, entity.dxf.end
    return Ring(np.array([[start.x, start.y], [end.x, end.y]]))


def _arc(entity: Any) -> Ring:
    start, end = 0.0, 360.0
    if entity.dxftype() == 'ARC':
        start, end = entity.dxf.start_angle, entity.dxf.end_angle
    sweep = math.radians((end - start) % 360.0) or 2.0 * math.pi
    steps = max(math.ceil(sweep / _ARC_STEP), 4)
    angle = math.radians(start) + np.linspace(0.0, sweep, steps + 1)
    points = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(steps + 1)])
    centre = entity.dxf.center
    points = entity.dxf.radius * points + (centre.x, centre.y, centre.z)
    return Ring(_to_world(entity, points), is_curve=True)


def _to_world(entity: Any, points: Array) -> Array:
    """Return points ``(N, 3)`` of an entity's own plane, which mirrored blocks turn over."""
    ocs = entity.ocs()
    if not ocs.transform:
        return points[:, :2]
    return np.array([(p.x, p.y) for p in ocs.points_to_wcs([tuple(q) for q in points])])


def _polyline(entity: Any) -> Ring:
    data = np.array(entity.get_points('xyb'), dtype=np.float64).reshape(-1, 3)
    points, is_curve = _bulged(data, entity.closed)
    height = np.full((len(points), 1), entity.dxf.elevation)
    return Ring(_to_world(entity, np.hstack([points, height])), is_curve, bool(entity.closed))


def _bulged(data: Array, is_closed: bool) -> tuple[Array, Any]:
    """Return points of vertices ``(x, y, bulge)``, where a bulge is an arc to the next vertex."""
    if not data[:, 2].any():
        return data[:, :2], np.zeros(len(data), dtype=np.bool_)
    points: list[Array] = []
    curve: list[Array] = []
    following = np.roll(data, -1, axis=0)
    for k, (x, y, bulge) in enumerate(data):
        is_arc = bool(bulge) and (is_closed or k + 1 < len(data))
        if not is_arc:
            points.append(np.array([[x, y]]))
            curve.append(np.zeros(1, dtype=np.bool_))
            continue
        arc = _bulge(np.array([x, y]), following[k, :2], float(bulge))
        points.append(arc)
        curve.append(np.ones(len(arc), dtype=np.bool_))
    return np.concatenate(points), np.concatenate(curve)


def _bulge(start: Array, end: Array, bulge: float) -> Array:
    """Return points of an arc without its end; ``bulge`` is the tangent of a quarter of it."""
    sweep = 4.0 * math.atan(bulge)
    chord = end - start
    normal = np.array([-chord[1], chord[0]])
    centre = 0.5 * (start + end) + normal * (1.0 - bulge**2) / (4.0 * bulge)
    steps = max(math.ceil(abs(sweep) / _ARC_STEP), 4)
    angle = np.linspace(0.0, sweep, steps, endpoint=False)
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = start - centre
    points: Array = centre + np.column_stack([x * cos - y * sin, x * sin + y * cos])
    return points


def _width(entity: Any) -> float:
    if entity.dxf.const_width:
        return float(entity.dxf.const_width)
    widths = np.array(entity.get_points('se'), dtype=np.float64)
    return float(np.median(widths)) if widths.size else 0.0


def _old_polyline(entity: Any) -> tuple[list[Ring], float]:
    if entity.is_poly_face_mesh or entity.is_polygon_mesh:
        faces = [p for p in _tolerant(entity.virtual_entities()) if p.dxftype() == '3DFACE']
        return [Ring(_face(face), is_closed=True) for face in faces], 0.0
    data = np.array(
        [(*v.dxf.location, v.dxf.get('bulge', 0.0)) for v in entity.vertices], dtype=np.float64
    ).reshape(-1, 4)
    if not len(data):
        return [], 0.0
    points, is_curve = _bulged(data[:, [0, 1, 3]], entity.is_closed)
    height = np.full((len(points), 1), data[0, 2])
    places = np.hstack([points, height])
    ring = Ring(
        _to_world(entity, places) if entity.is_2d_polyline else points, is_curve, entity.is_closed
    )
    return [ring], float(entity.dxf.get('default_start_width', 0.0))


def _curve(entity: Any) -> Ring:
    from ezdxf.path import make_path

    path = make_path(entity)
    controls = np.array([(v.x, v.y) for v in path.control_vertices()])
    size = float(np.ptp(controls, axis=0).max()) if len(controls) else 0.0
    points = [
        (v.x, v.y) for v in path.flattening(max(_CURVE_SHARE * 0.1 * size, 1e-9), segments=8)
    ]
    return Ring(np.array(points), is_curve=True)


_OUTLINES = {
    'LINE': _line,
    'ARC': _arc,
    'CIRCLE': _arc,
    'ELLIPSE': _curve,
    'SPLINE': _curve,
    'HELIX': _curve,
}


def _face(entity: Any) -> Array:
    corners = entity.wcs_vertices()
    return np.array([(p.x, p.y) for p in corners])


def _add_polygon(reader: _Reader, entity: Any, kind: str, paint: Paint) -> None:
    ring = Ring(_face(entity), is_closed=True)
    if kind == '3DFACE':
        reader.builder.add([ring], paint)
    else:
        reader.builder.add([ring], Paint(fill=BLACK, layer=paint.layer))


def _add_hatch(reader: _Reader, entity: Any, layer: str) -> None:
    """Add a hatch as an area: solid ones, and hatched ones on layers of walls."""
    from ezdxf.path import from_hatch

    rings = []
    for path in from_hatch(entity):
        points = np.array([(v.x, v.y) for v in path.flattening(_hatch_step(path), segments=8)])
        rings.append(Ring(points.reshape(-1, 2), is_closed=True))
    if entity.dxf.solid_fill or layer_role(layer) is Role.WALL:
        reader.builder.add(rings, Paint(fill=BLACK, layer=layer, is_even_odd=True))


def _hatch_step(path: Any) -> float:
    controls = np.array([(v.x, v.y) for v in path.control_vertices()])
    return max(float(np.ptp(controls, axis=0).max()) * 0.002, 1e-9) if len(controls) else 1.0


def _is_dash(linetype: str) -> bool:
    """Tell whether a line type's name says that it is broken."""
    name = linetype.casefold()
    return name not in ('continuous', 'bylayer', 'byblock', 'default', '')


def _entity_is_dashed(reader: _Reader, entity: Any) -> bool:
    linetype = str(entity.dxf.get('linetype', 'BYLAYER'))
    if linetype.casefold() in ('bylayer', 'byblock'):
        return reader.dashed.get(str(entity.dxf.get('layer', '0')).casefold(), False)
    return _is_dash(linetype)


def _label(entity: Any, kind: str) -> Label | None:
    """Return a text; its box is estimated from its height and number of letters."""
    text = entity.plain_text() if kind == 'MTEXT' else entity.dxf.text
    lines = [line.strip() for line in str(text).splitlines() if line.strip()]
    if not lines:
        return None
    height = float(entity.dxf.char_height if kind == 'MTEXT' else entity.dxf.height)
    size = np.array([max(map(len, lines)) * _TEXT_ASPECT * height, 1.3 * height * len(lines)])
    anchor, offset = _anchor(entity, kind)
    angle = _rotation(entity, kind)
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    corners = (np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) - offset) * size @ R.T + anchor
    if not np.isfinite(corners).all():
        return None
    low, high = corners.min(axis=0), corners.max(axis=0)
    box = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
    return Label(' '.join(lines), box)


def _anchor(entity: Any, kind: str) -> tuple[Array, Array]:
    """Return where a text is fixed and which part of its box lies there."""
    if kind == 'MTEXT':
        point, place = entity.dxf.insert, int(entity.dxf.attachment_point) - 1
        return np.array([point.x, point.y]), np.array([place % 3 / 2.0, 1.0 - place // 3 / 2.0])
    halign, valign = int(entity.dxf.get('halign', 0)), int(entity.dxf.get('valign', 0))
    is_plain = halign == 0 and valign == 0
    point = entity.dxf.insert if is_plain else entity.dxf.get('align_point', entity.dxf.insert)
    point = entity.ocs().to_wcs(point)
    offset = {1: 0.5, 2: 1.0, 4: 0.5}.get(halign, 0.0), {2: 0.5, 3: 1.0}.get(valign, 0.0)
    return np.array([point.x, point.y]), np.array(offset)


def _rotation(entity: Any, kind: str) -> float:
    if kind == 'MTEXT':
        return math.radians(entity.get_rotation())
    return math.radians(float(entity.dxf.get('rotation', 0.0)))
