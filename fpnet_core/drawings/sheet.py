# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Where on a sheet the building is, and what else is there.

Frames are rectangles with nothing attached that go around everything. What is left falls into
clusters of lines that lie close together; a building is the cluster that encloses most, and all
others are title blocks, legends, arrows and texts, unless they enclose nearly as much: then they
are other storeys.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.types import Dropped
from fpnet_core.errors import MapFormatError

Mask = NDArray[np.bool_]
Box = tuple[int, int, int, int]

FRAME = 'frame'
"""What a frame is called among what was dropped."""

# Chosen, not measured:
_LOOK_PX = 560  # the longer side of the picture that a sheet is looked over in
_MAX_FRAMES = 4
_FRAME_SPAN = 0.55  # of the drawn extent in both directions: smaller rectangles are no frames
_FRAME_INSET = 0.02  # of a frame's sides: where lines would cross that are attached to it
_DRAWN_SIDE = 0.75  # of each side of a frame is drawn
_BLANK_SIDE = 0.35  # of three sides of a frame in one piece has nothing attached
_BLANK_WORST = 0.25  # of its fourth side
_FACE_DEPTH, _FOLLOWED_SIDES = 0.04, 3  # how near to how many sides a wall's other face is
_FRAMED_INK = 0.2  # of all ink lies inside a frame and is not the frame
_BLOT_SHARE = 0.045  # of the longer side: what is as thick as this is a table under the sheet
_REACHES = (0.006, 0.012, 0.024)  # of the sheet's longer side: half the gaps within a building
_REACH = 0.014  # of the building's
_MOST = 0.5  # of what the widest reach joins is a building, not a part of it
_ROOM_SHARE = 1e-3  # of a cluster's area: smaller holes are no rooms
_WING_GAP = 0.03  # of the building's longer side
_WING_AREA, _STOREY_AREA = 0.12, 0.3  # of the building's
_STOREY_ROOMS, _WING_ROOMS = 4, 2
_STOREY_ROOM_SHARE = 0.25  # of the building's rooms: tables have fewer cells
_CORE_SHARE = 0.07  # of the building's longer side: texts in rooms are shorter
_DASH_SHARE = 0.012  # of the longer side: shorter pieces are letters and dashes
_HALL_SHARES = (0.04, 0.12, 0.6)  # of the sheet: larger spaces between lines may be no rooms
_HELD = 0.4  # of all lines lie in the building, or rooms may be larger,
_MANY_ROOMS = 7  # unless it has so many already
_HOLDS_MORE = 1.5  # times as many lines lie in a building with larger rooms
_JOINED, _RECTANGLE = 0.12, 0.93  # or a rectangle fills them, and so much of their outline
_SURROUNDED = 0.33  # unless the building lies around so much of their outline
_INWARD = np.array([1, 1, -1, -1])  # which way the sides of a box move where it shrinks
_TEXT_SHARE = 0.06  # of the longer side: lower clusters are texts


@dataclass(frozen=True)
class Cluster:
    """Lines that lie close together: where, what area they enclose and in how many rooms."""

    box: Box
    area: float
    rooms: int
    labels: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Sheet:
    """
    The buildings on a sheet, in reading order, and what is no building.

    ``boxes`` and ``dropped`` are in pixels of the sheet.
    """

    boxes: tuple[Box, ...]
    dropped: tuple[Dropped, ...]


class NoBuildingError(MapFormatError):
    """No lines of a sheet enclose anything."""


def find_building(ink: Mask) -> Sheet:
    """
    Find the buildings on a sheet with lines ``ink (H, W)``, and what else is there.

    Raises
    ------
    NoBuildingError
        If nothing on the sheet encloses anything.
    """
    factor = max(1.0, max(ink.shape) / _LOOK_PX)
    small = _reduced(ink, factor)
    frames, lines = _without_frames(small & ~_blots(small))
    main, others, labels = _clusters(_without_dashes(lines))
    buildings = sorted([main, *(o for o in others if _is_storey(o, main))], key=_reading_order)
    grounds = [_ground(np.isin(labels, building.labels)) for building in buildings]
    rest = lines & ~np.any(grounds, axis=0)
    dropped = [Dropped(FRAME, _scaled(box, factor)) for box in frames]
    dropped += [
        Dropped(_what(other, main), _scaled(other.box, factor))
        for other in _grouped(rest, _REACH * max(rest.shape), _HALL_SHARES[0])[1]
    ]
    return Sheet(tuple(_scaled(b.box, factor) for b in buildings), tuple(dropped))


def _without_dashes(lines: Mask) -> Mask:
    """Return the lines (H, W) without pieces as short as letters and dashes."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(lines.astype(np.uint8))
    longest = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1)
    keep = longest > _DASH_SHARE * max(lines.shape)
    keep[0] = False
    return np.asarray(keep[labels])


def _ground(near: Mask) -> Mask:
    """Return ``near (H, W)`` with its holes: all that stands on the building's ground."""
    contours, _ = cv2.findContours(
        near.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
    )
    ground = np.zeros(near.shape, dtype=np.uint8)
    cv2.drawContours(ground, contours, -1, 1, -1)
    return np.asarray(ground > 0)


def _reduced(ink: Mask, factor: float) -> Mask:
    """Return which pixels of the picture reduced by ``factor`` hold any ink."""
    size = [max(1, round(side / factor)) for side in ink.shape[::-1]]
    shares = cv2.resize(ink.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    return np.asarray(shares > min(0.9, 0.25 / factor))


def _scaled(box: Box, factor: float) -> Box:
    left, top, right, bottom = (round(side * factor) for side in box)
    return left, top, right, bottom


def _blots(ink: Mask) -> Mask:
    """Return what is thick and reaches the border: what a photographed sheet lies on."""
    side = max(5, round(_BLOT_SHARE * max(ink.shape)))
    padded = np.pad(ink.astype(np.uint8), side, mode='edge')
    core = cv2.morphologyEx(padded, cv2.MORPH_OPEN, np.ones((side, side), np.uint8))
    _, labels = cv2.connectedComponents(core, connectivity=8)
    inner = labels[side:-side, side:-side]
    rim = np.unique(np.concatenate([inner[0], inner[-1], inner[:, 0], inner[:, -1]]))
    found = np.isin(inner, rim[rim > 0]).astype(np.uint8)
    return np.asarray(cv2.dilate(found, np.ones((5, 5), np.uint8)) > 0)


def _without_frames(ink: Mask) -> tuple[list[Box], Mask]:
    """Return the boxes of frames around everything, outermost first, and the ink without."""
    frames: list[Box] = []
    for _ in range(_MAX_FRAMES):
        _, labels, stats, _ = cv2.connectedComponentsWithStats(ink.astype(np.uint8))
        found = _outermost_frame(ink, _ints(labels), _ints(stats))
        if found is None:
            break
        left, top, width, height, _ = stats[found].tolist()
        frames.append((left, top, left + width, top + height))
        ink = ink & (labels != found)
    return frames, ink


def _outermost_frame(ink: Mask, labels: NDArray[np.int32], stats: NDArray[np.int32]) -> int | None:
    """Return the label of the largest piece that is a frame."""
    rows, cols = np.flatnonzero(ink.any(axis=1)), np.flatnonzero(ink.any(axis=0))
    if not rows.size:
        return None
    extent = np.array([np.ptp(cols), np.ptp(rows)]) + 1
    wide = np.flatnonzero((stats[1:, 2:4] > _FRAME_SPAN * extent).all(axis=1)) + 1
    for label in wide[np.argsort(-stats[wide, 2] * stats[wide, 3].astype(np.int64))]:
        left, top, width, height, _ = stats[label].tolist()
        window = np.s_[top : top + height, left : left + width]
        own = labels[window] == label
        inset = max(3, round(_FRAME_INSET * max(width, height)))
        others = ink[window] & ~own
        is_around = others[inset:-inset, inset:-inset].sum() > _FRAMED_INK * ink.sum()
        if is_around and _is_bare(own, inset) and _stands_apart(others):
            return int(label)
    return None


def _stands_apart(others: Mask) -> bool:
    """
    Tell whether ``others``, what a rectangle goes around, does not follow it closely.

    The outer face of a wall of two lines is a rectangle, too. A frame of two lines follows a
    frame.
    """
    depth = max(3, round(_FACE_DEPTH * max(others.shape)))
    strips = [others[:depth].any(0), others[-depth:].any(0)]
    strips += [others[:, :depth].any(1), others[:, -depth:].any(1)]
    if sum(strip.mean() > _DRAWN_SIDE for strip in strips) < _FOLLOWED_SIDES:
        return True
    _, labels, stats, _ = cv2.connectedComponentsWithStats(others.astype(np.uint8))
    return _outermost_frame(others, _ints(labels), _ints(stats)) is not None


def _is_bare(own: Mask, inset: int) -> bool:
    """Tell whether a piece is a rectangle with hardly anything attached to its inner side."""
    edges = (
        own[:inset].any(0),
        own[-inset:].any(0),
        own[:, :inset].any(1),
        own[:, -inset:].any(1),
    )
    if min(edge.mean() for edge in edges) < _DRAWN_SIDE:
        return False
    sides = (own[inset], own[-1 - inset], own[:, inset], own[:, -1 - inset])
    blank = sorted(_longest_blank(side[inset:-inset]) for side in sides)
    return blank[0] > _BLANK_WORST and blank[1] > _BLANK_SIDE


def _longest_blank(side: Mask) -> float:
    """Return the share of the longest run without ink."""
    marks = np.concatenate([[-1], np.flatnonzero(side), [side.size]])
    return float((np.diff(marks) - 1).max() / max(side.size, 1))


def _clusters(ink: Mask) -> tuple[Cluster, list[Cluster], NDArray[np.int32]]:
    """
    Return the building, all other clusters, and the label of each pixel's cluster.

    Raises NoBuildingError where nothing is enclosed.
    """
    labels, clusters = _well_grouped(ink)
    main = max(clusters, key=_likeness)
    wings = [
        other
        for other in clusters
        if other is not main and (_is_wing(other, main) or _is_core(other, main))
    ]
    others = [other for other in clusters if other is not main and other not in wings]
    return _joined([main, *wings]), others, labels


def _well_grouped(ink: Mask) -> tuple[NDArray[np.int32], list[Cluster]]:
    """
    Return labels and clusters with spaces as large as it takes to hold most lines.

    Of a few large rooms on a small sheet each may be as large as what a frame encloses.
    """
    best: tuple[NDArray[np.int32], list[Cluster]] | None = None
    most = 0.0
    for hall in _HALL_SHARES:
        found = _reached(ink, hall)
        if found is None:
            continue
        main = max(found[1], key=_likeness)
        held = ink[_ground(np.isin(found[0], main.labels))].sum() / max(ink.sum(), 1)
        if best is None or held > _HOLDS_MORE * most:
            best, most = found, held
        if most > _HELD or main.rooms >= _MANY_ROOMS:
            break
    if best is None:
        raise NoBuildingError(
            'the drawing shows no building: no lines enclose anything; expected a floorplan '
            'with walls that stand out from the paper'
        )
    return best


def _reached(ink: Mask, hall: float) -> tuple[NDArray[np.int32], list[Cluster]] | None:
    """Return labels and clusters at the least reach that does not take a building apart."""
    found = [_grouped(ink, share * max(ink.shape), hall) for share in _REACHES]
    worth = [max(map(_likeness, clusters), default=0.0) for _, clusters in found]
    if max(worth) == 0.0:
        return None
    least = next(k for k, value in enumerate(worth) if value >= _MOST * max(worth))
    main = max(found[least][1], key=_likeness)
    left, top, right, bottom = main.box
    reach = _REACH * max(right - left, bottom - top)
    if reach <= _REACHES[least] * max(ink.shape):
        return found[least]
    wider = _grouped(ink, reach, hall)
    return wider if wider[1] else found[least]


def _grouped(ink: Mask, reach: float, hall: float) -> tuple[NDArray[np.int32], list[Cluster]]:
    """
    Return labels (H, W) of clusters and the clusters, of lines with gaps up to twice ``reach``.

    Spaces smaller than ``hall``, a share of the sheet, may be rooms.
    A cluster is where lines enclose something: single lines between them, as contours of the
    ground and dimensions, are no part of any.
    """
    by = max(1, round(reach))
    side = 4 * by + 4
    # A rim of blank paper lets the outside go around what touches the edge.
    grown = np.asarray(cv2.dilate(np.pad(ink, side).astype(np.uint8), _disc(by)), np.uint8)
    _, holes, sizes, _ = cv2.connectedComponentsWithStats(1 - grown, connectivity=4)
    holes, sizes = _ints(holes), _ints(sizes)
    solid = _with_halls(_opened(_filled(grown, holes, sizes, hall), 2 * by), holes, sizes, hall)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(solid, connectivity=8)
    own = np.bincount(_owners(_ints(labels), holes, sizes, count), minlength=count)
    clusters = []
    for label in range(1, count):
        left, top, width, height, area = stats[label].tolist()
        sides = np.array([left, top, left + width, top + height]) - side + by * _INWARD
        left, top, right, bottom = sides.tolist()
        box = (left, top, right, bottom)
        clusters.append(Cluster(_inside(box, ink.shape), float(area), int(own[label]), (label,)))
    return np.asarray(labels[side:-side, side:-side], dtype=np.int32), clusters


def _ints(values: NDArray[Any]) -> NDArray[np.int32]:
    """Return what OpenCV counted, as it is documented: its types say less."""
    return np.asarray(values, dtype=np.int32)


def _opened(mask: NDArray[np.uint8], by: int) -> NDArray[np.uint8]:
    return np.asarray(cv2.morphologyEx(mask, cv2.MORPH_OPEN, _disc(by)), dtype=np.uint8)


def _disc(radius: int) -> NDArray[np.uint8]:
    side = 2 * radius + 1
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)), dtype=np.uint8)


def _filled(
    grown: NDArray[np.uint8], holes: NDArray[np.int32], sizes: NDArray[np.int32], hall: float
) -> NDArray[np.uint8]:
    """Return ``grown`` with the holes filled that are as small as rooms."""
    small = sizes[:, cv2.CC_STAT_AREA] < hall * grown.size
    small[0] = small[holes[0, 0]] = False
    return np.asarray(grown | small[holes], dtype=np.uint8)


def _with_halls(
    solid: NDArray[np.uint8], holes: NDArray[np.int32], sizes: NDArray[np.int32], hall: float
) -> NDArray[np.uint8]:
    """Return ``solid`` with those larger holes that it surrounds for the most part."""
    solid = solid.copy()
    large = np.flatnonzero(sizes[:, cv2.CC_STAT_AREA] >= hall * solid.size)
    for label in large[(large > 0) & (large != holes[0, 0])]:
        space = (holes == label).astype(np.uint8)
        rim = cv2.dilate(space, _disc(2)) > space
        touching = float(solid[rim].mean())
        if touching > _SURROUNDED or (touching > _JOINED and _is_rectangle(space)):
            solid |= space
    return solid


def _is_rectangle(space: NDArray[np.uint8]) -> bool:
    """Tell whether a space, of a hundredth of the sheet or more, is one: a plain room."""
    contours, _ = cv2.findContours(space, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    outline = max(contours, key=cv2.contourArea)
    _, (width, height), _ = cv2.minAreaRect(outline)
    area = cv2.contourArea(outline)
    is_room = area < _HALL_SHARES[1] * space.size
    return bool(is_room and area > _RECTANGLE * max(width * height, 1.0))


def _owners(
    labels: NDArray[np.int32], holes: NDArray[np.int32], sizes: NDArray[np.int32], count: int
) -> NDArray[np.int64]:
    """Return the clusters in which holes lie that are no cracks; 0 for none."""
    found, first = np.unique(holes.ravel(), return_index=True)
    owner = labels.ravel()[first].astype(np.int64)
    area = np.bincount(labels.ravel(), minlength=count)
    is_room = sizes[found, cv2.CC_STAT_AREA] > _ROOM_SHARE * area[owner]
    return np.asarray(owner[is_room & (found > 0)])


def _inside(box: Box, shape: tuple[int, ...]) -> Box:
    left, top, right, bottom = box
    return max(left, 0), max(top, 0), min(right, shape[1]), min(bottom, shape[0])


def _likeness(cluster: Cluster) -> float:
    return cluster.area * min(1.0, (cluster.rooms + 0.2) / _STOREY_ROOMS)


def _is_wing(other: Cluster, main: Cluster) -> bool:
    side = max(main.box[2] - main.box[0], main.box[3] - main.box[1])
    is_near = _gap(other.box, main.box) < _WING_GAP * side
    return is_near and other.area > _WING_AREA * main.area and other.rooms >= _WING_ROOMS


def _is_core(other: Cluster, main: Cluster) -> bool:
    """Tell whether a cluster stands inside the building and is too large for a text."""
    a, b = other.box, main.box
    side = max(b[2] - b[0], b[3] - b[1])
    is_large = max(a[2] - a[0], a[3] - a[1]) > _CORE_SHARE * side
    return is_large and a[0] > b[0] and a[1] > b[1] and a[2] < b[2] and a[3] < b[3]


def _is_storey(other: Cluster, main: Cluster) -> bool:
    has_rooms = other.rooms >= max(_STOREY_ROOMS, _STOREY_ROOM_SHARE * main.rooms)
    return other.area > _STOREY_AREA * main.area and has_rooms


def _gap(a: Box, b: Box) -> float:
    across = max(a[0] - b[2], b[0] - a[2], 0)
    down = max(a[1] - b[3], b[1] - a[3], 0)
    return float(np.hypot(across, down))


def _joined(parts: list[Cluster]) -> Cluster:
    boxes = np.array([part.box for part in parts])
    left, top = boxes[:, :2].min(axis=0).tolist()
    right, bottom = boxes[:, 2:].max(axis=0).tolist()
    return Cluster(
        (left, top, right, bottom),
        sum(part.area for part in parts),
        sum(part.rooms for part in parts),
        tuple(label for part in parts for label in part.labels),
    )


def _reading_order(cluster: Cluster) -> tuple[int, int]:
    """Return a key that puts rows before columns; rows are as high as half a building."""
    left, top, _, bottom = cluster.box
    return round((top + bottom) / max(bottom - top, 1)), left


def _what(other: Cluster, main: Cluster) -> str:
    """Return what a cluster beside the building is, as far as its shape tells."""
    left, top, right, bottom = other.box
    side = max(main.box[2] - main.box[0], main.box[3] - main.box[1])
    if other.rooms >= _WING_ROOMS:
        return 'title block or legend'
    if min(right - left, bottom - top) < 0.2 * _TEXT_SHARE * side:
        return 'line'
    return 'text' if bottom - top < _TEXT_SHARE * side else 'drawing beside the building'
