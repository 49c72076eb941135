# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Outlines of DXF entities: lines, arcs, polylines, splines, faces."""

from __future__ import annotations

from collections.abc import Iterator
import math
from typing import Any

import numpy as np

from fpnet_core.drawings.formats.pages import Array, Ring
from fpnet_core.errors import MapFormatError

_CURVE_SHARE = 0.02  # numerical: of a curve's size, tolerance of its segments
_ARC_STEP = np.radians(7.5)  # numerical


def tolerant(parts: Iterator[Any]) -> Iterator[Any]:
    """Yield parts until one of them is damaged."""
    try:
        yield from parts
    except MapFormatError:
        raise
    except Exception:  # ezdxf raises many exception types on damaged entities
        return


def rings_of(entity: Any, kind: str) -> tuple[list[Ring], float]:
    """Return an entity's outline and its width."""
    if kind == 'POLYLINE':
        return _old_polyline(entity)
    if kind == 'LWPOLYLINE':
        return [_polyline(entity)], _width(entity)
    if kind == 'MLINE':
        parts = entity.virtual_entities()
        return [ring for part in parts for ring in rings_of(part, part.dxftype())[0]], 0.0
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
    """Return points ``(N, 3)`` of an entity's coordinate system, maybe mirrored, as world xy."""
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
    """Return points and curve flags of vertices ``(x, y, bulge)``; bulges are arcs to the next."""
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
    """Return points of an arc without its end; ``bulge`` is the tangent of sweep / 4."""
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
        faces = [p for p in tolerant(entity.virtual_entities()) if p.dxftype() == '3DFACE']
        return [Ring(corners_of(face), is_closed=True) for face in faces], 0.0
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


def corners_of(entity: Any) -> Array:
    """Return the corners of a face ``(N, 2)``, world coordinates."""
    corners = entity.wcs_vertices()
    return np.array([(p.x, p.y) for p in corners])


_OUTLINES = {
    'LINE': _line,
    'ARC': _arc,
    'CIRCLE': _arc,
    'ELLIPSE': _curve,
    'SPLINE': _curve,
    'HELIX': _curve,
}
