# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rooms, doors, edges, matches and hypotheses as ``visualization_msgs/MarkerArray``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fpnet_core.geometry import SE2, Affine2D, Placements
from fpnet_core.types import LocalizerOutput, RegionGraph, Segmentation
from msg_adapters.stamps import header_to_msg
from msg_adapters.transforms import matrix_to_pose_msg

Array = NDArray[np.float64]
Rgba = tuple[float, float, float, float]

# Chosen, not measured:
_ROOM, _DOOR, _EDGE = (0.2, 0.4, 0.8, 0.9), (0.9, 0.5, 0.1, 1.0), (0.4, 0.4, 0.4, 0.5)
_SUBMAP_ROOM, _SUBMAP_DOOR = (0.1, 0.7, 0.3, 1.0), (0.95, 0.8, 0.1, 1.0)
_UNSURE, _SURE = np.array((0.9, 0.1, 0.1)), np.array((0.1, 0.8, 0.2))
_BEST, _RUNNER_UP = (0.85, 0.1, 0.85), (0.6, 0.6, 0.6)
_WAY = (0.1, 0.5, 1.0, 0.9)
_THIN_M, _THICK_M, _ABOVE_M = 0.06, 0.15, 0.05  # line widths; height over the drawing
_ARROW_M = (1.2, 0.25, 0.25)  # length, width, height


def region_markers(
    segmentation: Segmentation,
    graph: RegionGraph | None,
    A_frame_grid: Affine2D,
    stamp_ns: int,
    frame_id: str,
    side: str,
) -> list[Any]:
    """
    Return markers for the outlines of rooms, lines of doors and edges of the graph.

    Parameters
    ----------
    A_frame_grid
        Transform from the frame of the segmentation [m] to ``frame_id`` [m].
    side
        ``plan`` or ``submap``: prefix of the namespaces, and choice of colours.
    """
    room, door = (_ROOM, _DOOR) if side == 'plan' else (_SUBMAP_ROOM, _SUBMAP_DOOR)
    outlines = [_closed(region.polygon) for region in segmentation.rooms]
    doors = [portal.ends for portal in segmentation.portals]
    markers = [
        _lines(f'{side}_rooms', A_frame_grid.apply(_joined(outlines)), room, _THIN_M),
        _lines(f'{side}_doors', A_frame_grid.apply(_joined(doors)), door, _THICK_M),
    ]
    if graph is not None and len(graph.edges):
        centroids = np.array([region.centroid for region in graph.regions])
        ends = A_frame_grid.apply(centroids[graph.edges.ravel()])
        markers.append(_lines(f'{side}_edges', ends, _EDGE, _THIN_M))
    return _stamped(markers, stamp_ns, frame_id)


def match_markers(
    plan: RegionGraph, output: LocalizerOutput, A_map_plan: Affine2D, stamp_ns: int, frame_id: str
) -> list[Any]:
    """
    Return lines between matched regions, red to green by score, under the best placement.

    Without a placement plan and submap have no common frame, and there are no lines.
    """
    match, graph = output.match, output.graph
    if match is None or graph is None or not len(match.pairs) or not output.estimates:
        return []
    A_map_submap = A_map_plan @ output.estimates[0].A_plan_submap
    ends = np.array(
        [
            (
                A_map_plan.apply(plan.regions[i].centroid),
                A_map_submap.apply(graph.regions[j].centroid),
            )
            for i, j in match.pairs
        ]
    )
    marker = _lines('matches', ends.reshape(-1, 2), (1.0, 1.0, 1.0, 1.0), _THICK_M)
    scores = np.repeat(match.scores, 2)[:, None].astype(np.float64)
    marker.colors = [_color((*rgb, 0.9)) for rgb in (1.0 - scores) * _UNSURE + scores * _SURE]
    return _stamped([marker], stamp_ns, frame_id)


def hypothesis_markers(
    estimates: Placements,
    A_map_plan: Affine2D,
    T_submap_base: SE2,
    stamp_ns: int,
    frame_id: str,
) -> list[Any]:
    """Return an arrow at the robot per placement, the best in colour; the score is opacity."""
    from geometry_msgs.msg import Vector3
    from visualization_msgs.msg import Marker

    markers = []
    for index, estimate in enumerate(estimates):
        A_map_submap = A_map_plan @ estimate.A_plan_submap
        x, y = A_map_submap.apply(T_submap_base.translation)
        pose = SE2.from_xy_yaw(float(x), float(y), A_map_submap.apply_yaw(T_submap_base.yaw))
        marker = Marker(ns='hypotheses', id=index, type=Marker.ARROW)
        marker.pose = matrix_to_pose_msg(pose.as_matrix4(_ABOVE_M))
        marker.scale = Vector3(**dict(zip('xyz', _ARROW_M, strict=True)))
        rgb = _RUNNER_UP if index else _BEST
        marker.color = _color((*rgb, float(np.clip(estimate.score, 0.2, 1.0))))
        markers.append(marker)
    return _stamped(markers, stamp_ns, frame_id)


def way_markers(way: Array, stamp_ns: int, frame_id: str) -> list[Any]:
    """Return lines along the path ``(P, 2)`` to where the robot should look next."""
    ends = np.stack([way[:-1], way[1:]], axis=1).reshape(-1, 2)
    return _stamped([_lines('next_look', ends, _WAY, _THICK_M)], stamp_ns, frame_id)


def markers_to_msg(markers: list[Any]) -> Any:
    """Return a MarkerArray that replaces all markers shown before."""
    from visualization_msgs.msg import Marker, MarkerArray

    return MarkerArray(markers=[Marker(action=Marker.DELETEALL), *markers])


def _closed(polygon: Array) -> Array:
    """Return the edges of a polygon (V, 2) as ends of lines (2 V, 2)."""
    return np.stack([polygon, np.roll(polygon, -1, axis=0)], axis=1).reshape(-1, 2)


def _joined(parts: list[Array]) -> Array:
    return np.concatenate([np.zeros((0, 2)), *parts])


def _lines(namespace: str, ends: ArrayLike, rgba: Rgba, width_m: float) -> Any:
    """Return a marker of separate lines; ``ends (2 L, 2)`` [m]."""
    from geometry_msgs.msg import Point, Vector3
    from visualization_msgs.msg import Marker

    marker = Marker(ns=namespace, type=Marker.LINE_LIST, scale=Vector3(x=width_m))
    marker.pose.orientation.w = 1.0
    marker.color = _color(rgba)
    marker.points = [Point(x=x, y=y, z=_ABOVE_M) for x, y in np.asarray(ends).tolist()]
    return marker


def _color(rgba: Iterable[float]) -> Any:
    from std_msgs.msg import ColorRGBA

    return ColorRGBA(**dict(zip('rgba', map(float, rgba), strict=True)))


def _stamped(markers: list[Any], stamp_ns: int, frame_id: str) -> list[Any]:
    for marker in markers:
        marker.header = header_to_msg(stamp_ns, frame_id)
    return [marker for marker in markers if marker.type != marker.LINE_LIST or marker.points]
