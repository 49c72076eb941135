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

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.pictures.frames import without_frames
from fpnet_core.drawings.types import Box, Dropped
from fpnet_core.errors import MapFormatError
from fpnet_core.raster.morphology import Mask, disc, grown, grown_by, opened_by, square
from fpnet_core.raster.pieces import filled, longer_pieces, pieces_of
from fpnet_core.raster.windows import border_of

FRAME = 'frame'
"""What a frame is called among what was dropped."""

# Chosen, not measured:
_LOOK_PX = 560  # the longer side of the picture that a sheet is looked over in
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
class SheetContents:
    """
    The buildings on a sheet, the largest first, and what is no building.

    ``boxes`` and ``dropped`` are in pixels of the sheet.
    """

    boxes: tuple[Box, ...]
    dropped: tuple[Dropped, ...]


class NoBuildingError(MapFormatError):
    """No lines of a sheet enclose anything."""


def find_building(ink: Mask) -> SheetContents:
    """
    Find the buildings on a sheet with lines ``ink (H, W)``, and what else is there.

    Raises
    ------
    NoBuildingError
        If nothing on the sheet encloses anything.
    """
    factor = max(1.0, max(ink.shape) / _LOOK_PX)
    small = _reduced(ink, factor)
    frames, lines = without_frames(small & ~_blots(small))
    main, others, labels = _clusters(longer_pieces(lines, _DASH_SHARE * max(lines.shape)))
    buildings = [main, *(o for o in others if _is_storey(o, main))]
    # All that stands on a building's ground belongs to it.
    grounds = [filled(np.isin(labels, building.labels)) for building in buildings]
    rest = lines & ~np.any(grounds, axis=0)
    dropped = [Dropped(FRAME, _scaled(box, factor)) for box in frames]
    dropped += [
        Dropped(_what(other, main), _scaled(other.box, factor))
        for other in _grouped(rest, _REACH * max(rest.shape), _HALL_SHARES[0])[1]
    ]
    return SheetContents(tuple(_scaled(b.box, factor) for b in buildings), tuple(dropped))


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
    core = opened_by(np.pad(ink, side, mode='edge'), square(side))
    inner = pieces_of(core)[0][side:-side, side:-side]
    rim = np.unique(border_of(inner))
    return grown(np.isin(inner, rim[rim > 0]), 2)


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
        held = ink[filled(np.isin(found[0], main.labels))].sum() / max(ink.sum(), 1)
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
    joined = grown_by(np.pad(ink, side), disc(2 * by + 1))
    holes, sizes = pieces_of(~joined, connectivity=4)
    filled = opened_by(_filled(joined, holes, sizes, hall), disc(4 * by + 1))
    solid = _with_halls(filled, holes, sizes, hall)
    labels, stats = pieces_of(solid)
    own = np.bincount(_owners(labels, holes, sizes, len(stats)), minlength=len(stats))
    clusters = []
    for label in range(1, len(stats)):
        left, top, width, height, area = stats[label].tolist()
        sides = np.array([left, top, left + width, top + height]) - side + by * _INWARD
        left, top, right, bottom = sides.tolist()
        box = (left, top, right, bottom)
        clusters.append(Cluster(_inside(box, ink.shape), float(area), int(own[label]), (label,)))
    return labels[side:-side, side:-side], clusters


def _filled(joined: Mask, holes: NDArray[np.int32], sizes: NDArray[np.int32], hall: float) -> Mask:
    """Return ``joined (H, W)`` with the holes filled that are as small as rooms."""
    small = sizes[:, cv2.CC_STAT_AREA] < hall * joined.size
    small[0] = small[holes[0, 0]] = False
    return np.asarray(joined | small[holes])


def _with_halls(
    solid: Mask, holes: NDArray[np.int32], sizes: NDArray[np.int32], hall: float
) -> Mask:
    """Return ``solid`` with those larger holes that it surrounds for the most part."""
    solid = solid.copy()
    large = np.flatnonzero(sizes[:, cv2.CC_STAT_AREA] >= hall * solid.size)
    for label in large[(large > 0) & (large != holes[0, 0])]:
        space = holes == label
        touching = float(solid[grown_by(space, disc(5)) & ~space].mean())
        if touching > _SURROUNDED or (touching > _JOINED and _is_rectangle(space)):
            solid |= space
    return solid


def _is_rectangle(space: Mask) -> bool:
    """Tell whether a space, of a hundredth of the sheet or more, is one: a plain room."""
    contours, _ = cv2.findContours(
        space.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
    )
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


def _what(other: Cluster, main: Cluster) -> str:
    """Return what a cluster beside the building is, as far as its shape tells."""
    left, top, right, bottom = other.box
    side = max(main.box[2] - main.box[0], main.box[3] - main.box[1])
    if other.rooms >= _WING_ROOMS:
        return 'title block or legend'
    if min(right - left, bottom - top) < 0.2 * _TEXT_SHARE * side:
        return 'line'
    return 'text' if bottom - top < _TEXT_SHARE * side else 'drawing beside the building'
