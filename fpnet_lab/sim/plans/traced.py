# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Conversion of a user's floorplan to a building, based on the product's segmentation.

Properties missing from a drawing are set as in generated storeys: walls of one thickness, doors
in the middle of their walls, heights from the extruder. Rooms with holes (a loop of corridors, a
hall with a core) are split into pieces joined by full-height openings, because a
:class:`PlanRoom` has one outline and no holes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray
import shapely
from shapely import LineString, Polygon
from shapely.geometry.polygon import orient

from fpnet_core.config import SegmentationConfig
from fpnet_core.errors import MapFormatError
from fpnet_core.raster.distance import nearest_labels
from fpnet_core.raster.pieces import cell_corners
from fpnet_core.raster.windows import NEIGHBOURS
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.segmentation.assemble import SIMPLIFY_CELLS
from fpnet_core.types import GridMap, Portal, Segmentation
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom, ring_of

Array = NDArray[np.float64]
RoomKind = Literal['room', 'corridor', 'hall']

TRACED = 'traced'
"""The ``family`` of plans that come from a drawing."""

WALL_RANGE_M = (0.08, 0.4)
USUAL_WALL_M = 0.15
"""
Limits of the estimated wall thickness, and its default if no two rooms share a wall. Chosen.
"""

# Chosen, not measured:
_SLIVER_M = 0.1  # half the width below which an area is too narrow for a room
_LEAST_ROOM_M2 = 0.5
_PILLAR_M2 = 0.3  # holes up to this size are filled: they do not affect connectivity
_LEAST_DOOR_M = 0.3
_JAMB_M = 0.15  # a doorway is cleared this far beyond its ends
_TONGUE_M = 0.6  # rooms extend through doors by less than this
_DEEPEST_DOOR_M = 1.5  # from the opening's line to either room
_WALL_SAMPLE_M = 0.8  # larger distances between rooms do not count as wall thickness
_THIN_PERCENT = 20.0
_MITRE_LIMIT = 1.5  # numerical: square corners stay sharp, acute corners are bevelled
# Numerical: positions of lines through a hole, as shares of the hole's extent.
_CUTS = (0.5, 0.25, 0.75)
_MOST_CUTS = 64  # numerical

# Chosen, not measured:
_CORRIDOR_ASPECT, _CORRIDOR_WIDTH_M, _CORRIDOR_DOORS = 3.0, 4.0, 2
_HALL_DOORS = 5


def plan_from_grid(grid: GridMap, config: SegmentationConfig | None = None) -> BuildingPlan:
    """
    Return the building shown in a floorplan.

    Parameters
    ----------
    grid : GridMap
        The drawing; its nominal scale is assumed to be correct.
    config : SegmentationConfig
        Segmentation into rooms; None uses the defaults.

    Returns
    -------
    BuildingPlan
        In the frame of ``grid``, family ``'traced'``. Rooms keep the segmentation's order unless
        they are split; rooms without a door and separate wings are kept. Outside doors become
        walls.

    Raises
    ------
    MapFormatError
        If no room is found.
    """
    drawn = segment_floorplan(grid, config or SegmentationConfig())
    if not drawn.rooms:
        raise MapFormatError(
            f'the floorplan has no rooms: {drawn.reason or "all free space is too small"}; '
            'expected free space enclosed by walls at the right metres per pixel'
        )
    wall_m = estimate_wall_m(drawn)
    areas = [_outline(drawn, room.id + 1) for room in drawn.rooms]
    for portal in drawn.portals:
        _part_at_door(areas, portal, wall_m)
    areas = _apart(areas, wall_m)
    pieces: list[Polygon] = []
    pieces_of: list[list[int]] = []
    seams: list[PlanDoor] = []
    for area in areas:
        parts, cuts = _without_holes(area, wall_m)
        first = len(pieces)
        pieces_of.append([first + k for k in range(len(parts))])
        seams += [PlanDoor((first + a, first + b), ends, is_open=True) for (a, b), ends in cuts]
        pieces += parts
    doors = [_door(portal, pieces, pieces_of) for portal in drawn.portals]
    every_door = (*(door for door in doors if door is not None), *seams)
    rooms = [PlanRoom(ring_of(piece)) for piece in pieces]
    return BuildingPlan(_with_kinds(rooms, every_door), every_door, wall_m, TRACED)


def estimate_wall_m(segmentation: Segmentation) -> float:
    """
    Return the thickness of the thinner walls, within limits [m].

    Walls thinner than the plan's thickness are widened and thicker walls stay. The estimate is
    therefore a low percentile of the distances between neighbouring rooms.
    """
    distance, room = nearest_labels(segmentation.labels)
    outside = segmentation.labels == 0
    widths = []
    for a, b in NEIGHBOURS[::-1]:
        meet = (room[a] != room[b]) & outside[a] & outside[b]
        # Distances are measured between cell centres; the two cells are one step apart.
        widths.append((distance[a][meet] + distance[b][meet]) * segmentation.grid.resolution)
    width = np.concatenate(widths)
    width = width[width < _WALL_SAMPLE_M]
    if not len(width):
        return USUAL_WALL_M
    return float(np.clip(np.percentile(width, _THIN_PERCENT), *WALL_RANGE_M))


def _outline(segmentation: Segmentation, label: int) -> Polygon:
    """Return the simplified area of a label with its holes [m]."""
    # segmentation.assemble.outline omits holes.
    corners = cell_corners(segmentation.labels == label)
    contours, hierarchy = cv2.findContours(corners, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    rings = [
        Polygon(segmentation.grid.rc_to_xy(ring[:, 0, ::-1] - 0.5)).buffer(0.0)
        if len(ring) >= 3
        else Polygon()
        for ring in contours
    ]
    is_hole = hierarchy[0, :, 3] >= 0
    solid = shapely.union_all(
        [ring for ring, hole in zip(rings, is_hole, strict=True) if not hole]
    )
    holes = [ring for ring, hole in zip(rings, is_hole, strict=True) if hole]
    area = shapely.difference(solid, shapely.union_all(holes)) if holes else solid
    return _largest(area.simplify(SIMPLIFY_CELLS * segmentation.grid.resolution).buffer(0.0))


def _part_at_door(areas: list[Polygon], portal: Portal, wall_m: float) -> None:
    """
    Move the boundary of two rooms to a door's line, in place, one wall thickness apart.

    The segmentation separates rooms somewhere in the doorway; parts beyond the line are swapped.
    """
    a, b = portal.rooms
    if b is None:
        return
    along = (portal.ends[1] - portal.ends[0]) / portal.width_m
    normal = np.array([-along[1], along[0]])
    ends = portal.ends + np.array([-1.0, 1.0])[:, None] * along * _JAMB_M

    def strip(start_m: float, end_m: float) -> Polygon:
        return Polygon([*(ends + start_m * normal), *(ends + end_m * normal)[::-1]])

    left, right = strip(wall_m / 2.0, _TONGUE_M), strip(-_TONGUE_M, -wall_m / 2.0)
    leans_left = areas[a].intersection(left).area + areas[b].intersection(right).area
    leans_right = areas[a].intersection(right).area + areas[b].intersection(left).area
    if leans_left < leans_right:
        left, right = right, left
    doorway = strip(-wall_m / 2.0, wall_m / 2.0)
    both = areas[a].union(areas[b])
    for room, own, foreign in ((a, left, right), (b, right, left)):
        ours = areas[room].difference(foreign).union(both.intersection(own))
        areas[room] = _largest(ours.difference(doorway))


def _apart(areas: list[Polygon], wall_m: float) -> list[Polygon]:
    """Return the areas, one wall thickness apart; areas that become too small are empty."""
    # Touching rooms shrink by half a wall each; the second pass widens walls still too thin.
    for reach_m in (wall_m / 2.0, wall_m):
        tree = shapely.STRtree(areas)
        grown = shapely.buffer(areas, reach_m, join_style='mitre', mitre_limit=_MITRE_LIMIT)
        near = [set(tree.query(area, 'dwithin', reach_m).tolist()) for area in areas]
        areas = [
            shapely.difference(area, shapely.union_all([grown[k] for k in near[index] - {index}]))
            for index, area in enumerate(areas)
        ]
    return [_tidy(area) for area in areas]


def _tidy(area: shapely.Geometry) -> Polygon:
    """Return the largest part of an area without slivers and pillars, or an empty polygon."""
    core = area.buffer(-_SLIVER_M, join_style='mitre')
    whole = _largest(core.buffer(_SLIVER_M, join_style='mitre').intersection(area))
    holes = [ring for ring in whole.interiors if Polygon(ring).area > _PILLAR_M2]
    tidy = Polygon(whole.exterior, holes)
    return tidy if tidy.area >= _LEAST_ROOM_M2 else Polygon()


def _largest(area: shapely.Geometry) -> Polygon:
    parts = [part for part in shapely.get_parts(area).tolist() if isinstance(part, Polygon)]
    return max(parts, key=lambda part: float(part.area), default=Polygon())


def _without_holes(
    area: Polygon, wall_m: float
) -> tuple[list[Polygon], list[tuple[tuple[int, int], Array]]]:
    """
    Split an area along lines through its holes until no piece has a hole.

    Returns the pieces, one wall thickness apart, and for each cut the indices of the two pieces
    and the ends (2, 2) of the opening between them. An empty area has no pieces.
    """
    pieces = [] if area.is_empty else [area]
    cuts: list[LineString] = []
    for _ in range(_MOST_CUTS):
        holed = next((k for k, piece in enumerate(pieces) if piece.interiors), None)
        if holed is None:
            break
        new = _shortest_cut(pieces[holed])
        gaps = shapely.union_all([cut.buffer(wall_m / 2.0, cap_style='flat') for cut in new])
        parts = shapely.get_parts(shapely.difference(pieces.pop(holed), gaps)).tolist()
        pieces += [part for part in parts if part.area >= _LEAST_ROOM_M2]
        cuts += new
    pieces = [orient(Polygon(piece.exterior)) for piece in pieces]
    joined = [(_sides(cut, pieces, wall_m), shapely.get_coordinates(cut)) for cut in cuts]
    return pieces, [(pair, ends) for pair, ends in joined if pair is not None]


def _shortest_cut(area: Polygon) -> list[LineString]:
    """
    Return the segments inside the area of the shortest line through its first hole.

    The line has area on both sides along its whole length, so every segment separates two pieces.
    """
    hole = Polygon(area.interiors[0])
    box = shapely.get_coordinates(hole.minimum_rotated_rectangle)[:4]
    reach = shapely.length(area.exterior)
    candidates = []
    for corner, along, across in (
        (box[0], box[1] - box[0], box[3] - box[0]),
        (box[0], box[3] - box[0], box[1] - box[0]),
    ):
        unit = along / np.linalg.norm(along)
        for share in _CUTS:
            middle = corner + share * across
            line = LineString([middle - reach * unit, middle + reach * unit])
            parts = shapely.get_parts(shapely.intersection(line, area)).tolist()
            candidates.append([part for part in parts if isinstance(part, LineString)])
    return min(candidates, key=lambda parts: sum(part.length for part in parts))


def _sides(cut: LineString, pieces: list[Polygon], wall_m: float) -> tuple[int, int] | None:
    """Return the indices of the pieces on both sides of a cut, or None if one was dropped."""
    ends = shapely.get_coordinates(cut)
    along = (ends[1] - ends[0]) / cut.length
    step = np.array([-along[1], along[0]]) * (wall_m / 2.0 + _SLIVER_M)
    middle = ends.mean(axis=0)
    found = [
        [k for k, piece in enumerate(pieces) if piece.distance(shapely.Point(side)) < _SLIVER_M]
        for side in (middle - step, middle + step)
    ]
    if not all(found) or found[0][0] == found[1][0]:
        return None
    return found[0][0], found[1][0]


def _door(portal: Portal, pieces: list[Polygon], pieces_of: list[list[int]]) -> PlanDoor | None:
    """Return a portal's door between the nearest pieces of its rooms, or None if one is lost."""
    line = LineString(portal.ends)
    sides = []
    for room in portal.rooms:
        if room is None or portal.width_m < _LEAST_DOOR_M:
            return None
        distances = [(float(shapely.distance(pieces[k], line)), k) for k in pieces_of[room]]
        if not distances or min(distances)[0] > _DEEPEST_DOOR_M:
            return None
        sides.append(min(distances)[1])
    return PlanDoor((sides[0], sides[1]), np.array(portal.ends))


def _with_kinds(rooms: Sequence[PlanRoom], doors: Sequence[PlanDoor]) -> tuple[PlanRoom, ...]:
    """Return the rooms with their kinds, classified by shape and number of doors."""
    count = np.bincount([room for door in doors for room in door.rooms], minlength=len(rooms))
    return tuple(
        PlanRoom(room.polygon, _kind(Polygon(room.polygon), int(number)))
        for room, number in zip(rooms, count, strict=True)
    )


def _kind(outline: Polygon, doors: int) -> RoomKind:
    """Return a room's kind; the rectangle of equal area and perimeter gives width and length."""
    half, area = outline.length / 2.0, outline.area
    root = np.sqrt(max(half**2 / 4.0 - area, 0.0))
    width, length = half / 2.0 - root, half / 2.0 + root
    is_long = length > _CORRIDOR_ASPECT * width and width < _CORRIDOR_WIDTH_M
    if is_long and doors >= _CORRIDOR_DOORS:
        return 'corridor'
    return 'hall' if doors >= _HALL_DOORS else 'room'
