# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Horizontal sections of IFC bodies as rings."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.formats.pages import Array, Ring

_JOIN_M = 1e-4  # numerical: ends of section lines this close are joined

Triangles = tuple[Array, NDArray[np.int64]]
"""Vertices (V, 3) [m], and the three vertex indices of each face (F, 3)."""


def triangles(element: Any, settings: Any) -> Triangles | None:
    """Return an element's body in world coordinates; None without a valid one."""
    import ifcopenshell.geom

    if element.Representation is None:
        return None
    shape: Any = None
    with suppress(Exception):  # IfcOpenShell raises many types on damaged bodies
        shape = ifcopenshell.geom.create_shape(settings, element)
    if shape is None:
        return None
    vertices = np.array(shape.geometry.verts, dtype=np.float64).reshape(-1, 3)
    faces = np.array(shape.geometry.faces, dtype=np.int64).reshape(-1, 3)
    return (vertices, faces) if len(faces) and np.isfinite(vertices).all() else None


def section(vertices: Array, faces: Any, height: float) -> Array:
    """Return the segments ``(N, 2, 2)`` at which the triangles of a body cross a height."""
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


def loops(pieces: Array) -> list[Ring]:
    """Return closed rings joined from segments; open chains are dropped."""
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
    """Return the points of a chain of unused segments until it closes or ends."""
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
