# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Export of a floorplan model as DXF with AIA layers, or SVG with named groups."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from fpnet.exports.solids import middle_of, solid_walls
from fpnet_core.drawings.model import FloorplanModel, ModelDoor, Rings
from fpnet_core.drawings.model_raster import rectangle
from fpnet_core.drawings.types import Array
from fpnet_core.errors import ConfigError

_METRES = 6  # given: $INSUNITS
_LETTER_M = 0.25  # chosen: height of rooms' names
_MARGIN_M = 1.0  # chosen: around the building on a page
_MM_PER_M = 10.0  # chosen: an SVG is at 1:100
_LINE_MM = 0.25  # chosen
_ARC_STEPS = 12  # numerical: segments of a door's arc


def write_dxf(model: FloorplanModel, path: Path) -> None:
    """
    Write a DXF in metres: walls, windows, doors with their leaves, rooms with names.

    Raises
    ------
    ConfigError
        If ezdxf is not installed.
    """
    try:
        from ezdxf.filemanagement import new
    except ImportError:
        raise ConfigError(f"{path}: a DXF needs ezdxf; pip install 'fpnet_ros[plans]'") from None
    document = new('R2010')
    document.header['$INSUNITS'] = _METRES
    for layer in ('A-WALL', 'A-GLAZ', 'A-DOOR', 'A-AREA', 'A-AREA-IDEN'):
        document.layers.add(layer)
    space = document.modelspace()

    def closed(rings: Rings, layer: str) -> None:
        for ring in rings:
            space.add_lwpolyline(ring.tolist(), close=True, dxfattribs={'layer': layer})

    for rings in solid_walls(model):
        closed(rings, 'A-WALL')
    for window in model.windows:
        closed((rectangle(window),), 'A-GLAZ')
    for door in model.doors:
        leaf, arc = symbol(door)
        space.add_line(leaf[0].tolist(), leaf[1].tolist(), dxfattribs={'layer': 'A-DOOR'})
        space.add_lwpolyline(arc.tolist(), dxfattribs={'layer': 'A-DOOR'})
    for room in model.rooms:
        closed(room.rings, 'A-AREA')
        if room.name:
            space.add_text(
                room.name, height=_LETTER_M,
                dxfattribs={'insert': middle_of(room).tolist(), 'layer': 'A-AREA-IDEN'},
            )  # fmt: skip
    document.saveas(path)


def symbol(door: ModelDoor) -> tuple[Array, Array]:
    """Return a door symbol: open leaf (2, 2) and swing arc (A, 2)."""
    hinge = door.hinge or 0
    start, end = door.ends[hinge], door.ends[1 - hinge]
    shut = end - start
    across = np.array([-shut[1], shut[0]])
    if door.leaf is not None and float(across @ (door.leaf - start)) < 0.0:
        across = -across
    angle = np.linspace(0.0, 0.5 * np.pi, _ARC_STEPS + 1)[:, None]
    arc = start + np.cos(angle) * shut + np.sin(angle) * across
    return np.array([start, start + across]), arc


def write_svg(model: FloorplanModel, path: Path, name: str) -> None:
    """Write an SVG at 1:100: groups of rooms, walls, windows, doors and names."""
    points = model.points if len(model.points) else np.zeros((1, 2))
    low, high = points.min(axis=0) - _MARGIN_M, points.max(axis=0) + _MARGIN_M
    width, height = _MM_PER_M * (high - low)

    def place(points: Array) -> str:
        x, y = (_MM_PER_M * (points - low)).T
        return ' '.join(f'{a:.3f},{height - b:.3f}' for a, b in zip(x, y, strict=True))

    def area(rings: Rings) -> str:
        return f'<path d="{" ".join(f"M{place(ring)}Z" for ring in rings)}"/>'

    def line(points: Array) -> str:
        return f'<polyline points="{place(points)}"/>'

    names = []
    for room in model.rooms:
        x, y = place(middle_of(room)[None]).split(',')
        size = _MM_PER_M * _LETTER_M
        names.append(
            f'<text x="{x}" y="{y}" font-size="{size:g}" text-anchor="middle">'
            f'{escape(room.name)}</text>'
        )
    thin = f'fill="none" stroke="#000" stroke-width="{_LINE_MM}"'
    groups = (
        ('rooms', 'fill="#fff"', [area(room.rings) for room in model.rooms]),
        ('walls', 'fill="#000" fill-rule="evenodd"', map(area, solid_walls(model))),
        ('windows', thin, [area((rectangle(each),)) for each in model.windows]),
        ('doors', thin, [line(part) for door in model.doors for part in symbol(door)]),
        ('names', 'font-family="sans-serif"', names),
    )
    body = ''.join(f'<g id="{key}" {style}>{"".join(of)}</g>\n' for key, style, of in groups)
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" '
        f'viewBox="0 0 {width:g} {height:g}" aria-label={quoteattr(name)}>\n{body}</svg>\n',
        encoding='utf-8',
    )
