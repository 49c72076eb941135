# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reader of DXF: visible layers of the model space with exploded blocks, and units.

External references, images and underlays are never followed. Colours are dropped: in CAD programs
they distinguish layers, and layers have names.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
import math
from pathlib import Path
from typing import Any

import numpy as np

from fpnet_core.drawings.formats.dxf_outlines import corners_of, rings_of, tolerant
from fpnet_core.drawings.formats.layers import LayerRole, layer_role
from fpnet_core.drawings.formats.messages import detail_of
from fpnet_core.drawings.formats.pages import (
    BLACK,
    MAX_NESTED,
    Array,
    PageBuilder,
    Paint,
    Ring,
    UnitKind,
    VectorPage,
)
from fpnet_core.drawings.lengths import FOOT_M, INCH_M
from fpnet_core.drawings.types import Label, ReadOptions
from fpnet_core.errors import MapFormatError

MAX_ENTITIES = 300_000
"""Numerical: limit of entities after exploding blocks; nested blocks multiply."""

_END, _END_BYTES = b'EOF', 64  # given: end marker of a file, searched for in its last bytes
# Given: $INSUNITS.
_UNITS_M = {1: INCH_M, 2: FOOT_M, 4: 0.001, 5: 0.01, 6: 1.0, 7: 1000.0, 10: 0.9144, 14: 0.1, 21:
            1200 / 3937}  # fmt: skip
# Chosen, not measured:
_TEXT_ASPECT = 0.7  # of a letter, width to height
_LEFT_OUT = frozenset({
    'IMAGE', 'PDFUNDERLAY', 'DWFUNDERLAY', 'DGNUNDERLAY', 'OLE2FRAME', 'OLEFRAME', 'WIPEOUT',
})  # fmt: skip
_POLYGONS = frozenset({'SOLID', 'TRACE', '3DFACE'})


@dataclass
class _Reader:
    """State of the traversal of a document's entities."""

    builder: PageBuilder
    hidden: frozenset[str]
    dashed: dict[str, bool]
    count: int = 0
    damaged: int = 0
    left_out: dict[str, int] = field(default_factory=dict)


def load_libraries() -> None:
    """Import the libraries of this reader before the process is restricted."""
    import ezdxf.path
    import ezdxf.recover  # noqa: F401


def read_dxf(path: Path, options: ReadOptions) -> VectorPage:
    """
    Return the model space of a DXF file.

    Raises
    ------
    MapFormatError
        If the file is damaged beyond recovery, truncated or too large.
    """
    document = _load(path)
    if not _has_end(path):
        raise MapFormatError(
            f'{path.name} is truncated: it lacks the EOF marker of a DXF file and may lack walls; '
            'copy it again, or save it again as DXF 2010 or later'
        )
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

    with suppress(Exception):  # damaged: the slow, tolerant reader may succeed
        return filemanagement.readfile(path)
    try:
        document, _ = recover.readfile(path)
    except Exception as error:  # ezdxf raises many exception types on damaged files
        raise MapFormatError(
            f'{path.name} is a damaged DXF file ({detail_of(error)}); save it again as DXF 2010 '
            'or later'
        ) from None
    return document


def _has_end(path: Path) -> bool:
    """Return whether a DXF file, text or binary, has its end marker."""
    with path.open('rb') as file:
        file.seek(max(0, path.stat().st_size - _END_BYTES))
        return _END in file.read()


def _refuse_growth(document: Any, name: str) -> None:
    """Reject documents whose nested blocks expand to too many entities."""
    sizes: dict[str, int] = {}

    def size(container: Any, depth: int) -> int:
        total = 0
        for entity in container:
            total += 1
            if entity.dxftype() == 'INSERT' and depth < MAX_NESTED:
                total += max(int(entity.mcount), 1) * block_size(str(entity.dxf.name), depth + 1)
            if total > MAX_ENTITIES:
                break
        return total

    def block_size(key: str, depth: int) -> int:
        if key not in sizes:
            sizes[key] = MAX_ENTITIES + 1  # while it is being counted: a recursive block
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
    """Yield the visible entities of a container, blocks exploded, with their layers."""
    from ezdxf.entities.dxfgfx import DXFGraphic

    for entity in container:
        if not isinstance(entity, DXFGraphic):  # of a type unknown to ezdxf
            continue
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
    """Return the layer's name, with that of the block if only the latter is recognized."""
    is_extended = (
        block and layer_role(layer) is LayerRole.UNKNOWN and layer_role(block) != LayerRole.UNKNOWN
    )
    return f'{layer}: {block}' if is_extended else layer


def _insert(
    reader: _Reader, insert: Any, layer: str, block: str, depth: int
) -> Iterator[tuple[Any, str]]:
    definition = insert.block()
    if definition is None or depth >= MAX_NESTED:
        return
    if definition.block is not None and definition.block.is_xref:
        reader.left_out['XREF'] = reader.left_out.get('XREF', 0) + 1
        return
    name = block if block and layer_role(block) != LayerRole.UNKNOWN else str(insert.dxf.name)
    copies = insert.multi_insert() if insert.mcount > 1 else [insert]
    for copy in copies:
        parts = tolerant(copy.virtual_entities(skipped_entity_callback=_ignore))
        yield from _entities(reader, parts, layer, name, depth + 1)
        for attribute in copy.attribs:
            yield attribute, layer


def _ignore(entity: Any, reason: str) -> None:
    """Skip an entity that cannot be exploded, like ezdxf."""


def _dimension(reader: _Reader, dimension: Any, layer: str) -> Iterator[tuple[Any, str]]:
    for part in tolerant(dimension.virtual_entities()):
        reader.count += 1
        yield part, f'{layer}: dimensions'


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
            rings, width = rings_of(entity, kind)
            reader.builder.add(rings, replace(paint, width=width))
    except MapFormatError:
        raise
    except Exception:  # a damaged entity; the others may be valid
        reader.damaged += 1


def _add_polygon(reader: _Reader, entity: Any, kind: str, paint: Paint) -> None:
    ring = Ring(corners_of(entity), is_closed=True)
    if kind == '3DFACE':
        reader.builder.add([ring], paint)
    else:
        reader.builder.add([ring], Paint(fill=BLACK, layer=paint.layer))


def _add_hatch(reader: _Reader, entity: Any, layer: str) -> None:
    """Add a hatch as an area if it is solid or on a layer of walls."""
    from ezdxf.path import from_hatch

    rings = []
    for path in from_hatch(entity):
        points = np.array([(v.x, v.y) for v in path.flattening(_hatch_step(path), segments=8)])
        rings.append(Ring(points.reshape(-1, 2), is_closed=True))
    if entity.dxf.solid_fill or layer_role(layer) is LayerRole.WALL:
        reader.builder.add(rings, Paint(fill=BLACK, layer=layer, is_even_odd=True))


def _hatch_step(path: Any) -> float:
    controls = np.array([(v.x, v.y) for v in path.control_vertices()])
    return max(float(np.ptp(controls, axis=0).max()) * 0.002, 1e-9) if len(controls) else 1.0


def _is_dash(linetype: str) -> bool:
    """Return whether a line type is dashed, by its name."""
    name = linetype.casefold()
    return name not in ('continuous', 'bylayer', 'byblock', 'default', '')


def _entity_is_dashed(reader: _Reader, entity: Any) -> bool:
    linetype = str(entity.dxf.get('linetype', 'BYLAYER'))
    if linetype.casefold() in ('bylayer', 'byblock'):
        return reader.dashed.get(str(entity.dxf.get('layer', '0')).casefold(), False)
    return _is_dash(linetype)


def _label(entity: Any, kind: str) -> Label | None:
    """Return a label; its box is estimated from text height and number of letters."""
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
    """Return the anchor of a text and the anchor's relative position in its box."""
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
