# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Triangle meshes of buildings, extruded from polygons."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.polygon import orient

Array = NDArray[np.float64]

_FLAT = 2  # given: dimension of a polygon; a line has 1


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A mesh of ``vertices (V, 3) float64`` [m] and ``triangles (T, 3) int64`` (indices)."""

    vertices: Array
    triangles: NDArray[np.int64]

    @property
    def corners(self) -> Array:
        """Corner points of the triangles (T, 3, 3) [m]."""
        corners: Array = self.vertices[self.triangles]
        return corners


def merge_meshes(meshes: Sequence[TriangleMesh]) -> TriangleMesh:
    """Return one mesh with all triangles; it is empty if there are no meshes."""
    if not meshes:
        return TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    return TriangleMesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate(
            [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=True)]
        ),
    )


def extrude_polygon(area: Polygon | MultiPolygon, bottom_m: float, top_m: float) -> TriangleMesh:
    """Return the outward-facing surface of the prism over ``area``, which may have holes."""
    parts = [part for part in shapely.get_parts(area).tolist() if isinstance(part, Polygon)]
    pieces = []
    for part in map(orient, parts):  # outer rings counter-clockwise, holes clockwise
        rings = [part.exterior, *part.interiors]
        pieces += [_side_faces(shapely.get_coordinates(r)[:-1], bottom_m, top_m) for r in rings]
        pieces += [_cap(part, top_m, is_top=True), _cap(part, bottom_m, is_top=False)]
    return merge_meshes(pieces)


def horizontal_sheet(area: Polygon, z_m: float, faces_up: bool) -> TriangleMesh:
    """Return a horizontal polygon at height ``z_m``: a floor (facing up) or a ceiling."""
    return _cap(area, z_m, is_top=faces_up)


def _side_faces(ring: Array, bottom_m: float, top_m: float) -> TriangleMesh:
    """Return two triangles per edge of a ring (V, 2) with the solid on its left."""
    count = len(ring)
    low = np.arange(count)
    next_low = np.roll(low, -1)
    triangles = np.concatenate(
        [
            np.stack([low, next_low, next_low + count], axis=1),
            np.stack([low, next_low + count, low + count], axis=1),
        ]
    )
    vertices = np.concatenate(
        [np.column_stack([ring, np.full(count, z)]) for z in (bottom_m, top_m)]
    )
    return TriangleMesh(vertices, triangles)


def _cap(area: Polygon, z_m: float, is_top: bool) -> TriangleMesh:
    corners = _triangles(area)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    is_left = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0] > 0.0
    corners = np.where((is_left == is_top)[:, None, None], corners, corners[:, ::-1])
    flat = corners.reshape(-1, 2)
    vertices = np.column_stack([flat, np.full(len(flat), z_m)])
    return TriangleMesh(vertices, np.arange(len(flat), dtype=np.int64).reshape(-1, 3))


def _triangles(area: Polygon) -> Array:
    """
    Return triangles ``(T, 3, 2)`` that fill a polygon, in arbitrary orientation.

    Delaunay triangles ignore the polygon's edges, so triangles that cross an edge are clipped. No
    corner of the polygon is inside a triangle, so all pieces are convex.
    """
    shapely.prepare(area)
    found = shapely.get_parts(shapely.delaunay_triangles(area))
    is_whole = shapely.covers(area, found)
    crossed = found[~is_whole & shapely.intersects(area, found)]
    pieces = shapely.get_parts(shapely.intersection(crossed, area))
    pieces = pieces[shapely.get_dimensions(pieces) == _FLAT]
    cut = shapely.get_parts(shapely.delaunay_triangles(pieces))
    triangles = np.concatenate([found[is_whole], cut])
    rings: Array = shapely.get_coordinates(triangles).reshape(len(triangles), 4, 2)
    return rings[:, :3]
