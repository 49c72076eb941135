# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Segmentation of a robot's partial map into rooms and doors (paper, section III-B)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask, closed, grown, opened, shrunk, spread, square
from fpnet_core.raster.pieces import label_extents, label_windows, looked_up
from fpnet_core.raster.windows import Window, cells_of, cropped
from fpnet_core.segmentation.assemble import RoomScore, assemble
from fpnet_core.segmentation.furniture import furniture_cells
from fpnet_core.segmentation.lintels import Doorway, find_lintels
from fpnet_core.segmentation.openings import MIN_DOOR_WIDTH_M, Opening
from fpnet_core.segmentation.rooms import MIN_ROOM_WIDTH_M, Decide, cut_rooms, joined_as_learned
from fpnet_core.segmentation.scene import Scene
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Segmentation, Submap

# Free space narrower than this is a stray ray;
# fitted to the development split (notes/segmentation.md).
_SOLID_WIDTH_M = 0.2
# Glimpsed rooms smaller than this are dropped (a_th of the paper);
# fitted to the development split (notes/segmentation.md).
_MIN_SUBMAP_ROOM_AREA_M2 = 2.0

# Chosen, not measured:
# Unknown cells this near to a wall are the wall's shadow, not a frontier [m].
_WALL_SHADOW_M = 0.1
# The ends of a doorway's line are at most this far from its jambs [m].
_JAMB_REACH_M = 0.2
# Narrower openings are holes in a wall that was seen too rarely, not doors [m].
_MIN_DOOR_M = 0.3
# Numerical: margin of unseen space around the grid into which rooms may extend [cells].
_BEYOND_CELLS = 40
# Numerical: height of the strips in which a room is scanned until its wide part suffices [cells].
_STRIP_CELLS = 64
# Rays prove nothing on their last stretch: a rim of unknown cells up to this wide is free [m].
_RIM_M = 0.2
# Only rim cells this near to returns are free; others may be a wall that no ray hit [m].
_RIM_REACH_M = 0.1
# A wall's face lies this far inside the cells that hold its returns [m].
_SCATTER_M = 0.05
# Returns with unseen space this near behind them are of one face, not of a wall's two sides [m].
_ONE_FACE_M = 0.15


def segment_submap(submap: Submap, metres_per_unit: float = 1.0) -> Segmentation:
    """
    Segment a partial map into rooms and doors.

    Lintels close their doorways first. The rest is the watershed of :func:`segment_floorplan`,
    except that unknown space is neither wall nor free: regions end there, and each records the
    unseen share of its outline and area. Rooms that were only glimpsed are dropped; the doors that
    lead to them stay, with None as second room.

    Parameters
    ----------
    submap : the raster and its lintel mask
    metres_per_unit : true metres per nominal metre, 1 for a lidar's own submap

    Returns
    -------
    Segmentation in the submap frame; an empty one with a reason if nothing was found
    """
    has_scans = is_from_scans(submap)
    return segment_part(submap.grid, submap.lintel, metres_per_unit, has_scans=has_scans)


def is_from_scans(submap: Submap) -> bool:
    """Return whether this is a robot's own submap; a finished map ends at its free cells."""
    return len(submap.path_xy) > 0


def segment_part(
    grid: GridMap,
    lintel: Mask,
    metres_per_unit: float = 1.0,
    held: Mask | None = None,
    known_doors: Sequence[Doorway] = (),
    held_doors: Sequence[Doorway] = (),
    has_scans: bool = True,
    sees_lintels: bool | None = None,
    decide: Decide = joined_as_learned,
) -> Segmentation:
    """
    Segment a window of a partial map into rooms and doors.

    Parameters
    ----------
    grid, lintel : the window's cells and lintel mask
    metres_per_unit : as for :func:`segment_submap`
    held : (H, W) bool, cells of known rooms, which count but are not segmented again; None for
        none
    known_doors : doorways between held and other rooms, in the window's cells
    held_doors : doorways between held rooms; they are closed but not returned
    has_scans : whether occupied cells are cells with scan returns
    sees_lintels : whether the sensor has detected lintels anywhere; None: check the window
    decide : decides which pieces merge
    """
    cell_m = grid.resolution * metres_per_unit
    closed_doors = (*held_doors, *known_doors)
    made = part_scene(grid, lintel, cell_m, closed_doors, has_scans, sees_lintels, held)
    if made is None:
        empty = np.zeros(grid.shape, dtype=np.int32)
        return Segmentation(grid, empty, (), (), 'the submap has no free space')
    scene, doorways = made
    assert scene.unseen is not None, 'part_scene sets the unseen cells'
    inside = scene if held is None else replace(scene, free=scene.free & ~held)
    full, openings, _ = cut_rooms(inside, decide)
    openings = [opening for opening in openings if _width_m(opening, cell_m) >= _MIN_DOOR_M]
    openings += [door.between(full) for door in doorways[len(held_doors) :]]
    full = _drop_glimpses(full, cell_m)
    rooms = set(label_windows(full))
    openings = [door for door in openings if _leads_somewhere(door, rooms, cell_m)]
    openings = _without_holes(openings, scene.sees_lintels, cell_m)
    if has_scans:
        full = _to_faces(full, grid.cells, held, cell_m)
    return assemble(grid, full, openings, metres_per_unit, _scores(full, scene.unseen))


def part_scene(
    grid: GridMap,
    lintel: Mask,
    cell_m: float,
    known_doors: Sequence[Doorway] = (),
    has_scans: bool = True,
    sees_lintels: bool | None = None,
    held: Mask | None = None,
) -> tuple[Scene, list[Doorway]] | None:
    """
    Return the scene of a partial map and its closed doorways; None without free space.

    ``known_doors`` come first. No other doorways are searched for in ``held`` cells.
    """
    wall = grid.cells == OCCUPIED
    free = grid.cells == FREE
    if has_scans:
        free = _to_walls(free, wall, cell_m)
    free = _solid(free, cell_m)
    if not free.any():
        return None
    jambs = _grown(wall, _JAMB_REACH_M, cell_m)
    shut, doorways = find_lintels(lintel & free, free, jambs, cell_m, known_doors, held)
    # Closed doorways connect wall stubs between them to other walls: such stubs are no furniture.
    open_cells = free & ~shut
    furniture = furniture_cells(open_cells, cell_m) & ~shut
    scene = replace(
        _scene(open_cells | furniture | shut, shut, wall, cell_m),
        furniture=furniture,
        high=lintel,
        has_scans=has_scans,
        sees_lintels=bool(lintel.any()) if sees_lintels is None else sees_lintels,
    )
    return scene, doorways


def _scene(free: Mask, lintel: Mask, returns: Mask, cell_m: float) -> Scene:
    """Return the scene of a partial map."""
    wall = _grown(returns | lintel, _WALL_SHADOW_M, cell_m)
    return Scene(free, lintel, (~free & wall) | lintel, cell_m, wall, ~(free | wall))


def _leads_somewhere(opening: Opening, rooms: set[int], cell_m: float) -> bool:
    """Return whether an opening joins two of ``rooms`` or is certainly a door."""
    if opening.has_lintel or _width_m(opening, cell_m) >= MIN_DOOR_WIDTH_M:
        return True
    return rooms.issuperset(opening.rooms)


def _without_holes(openings: list[Opening], sees_lintels: bool, cell_m: float) -> list[Opening]:
    """
    Return ``openings`` without holes that sparse scans have left in the wall beside a door.

    Two rooms rarely have more than one door. A second opening between them without a lintel is a
    hole if the sensor sees lintels, or else if it is narrower than a door. The widest one stays.
    """

    def rank(opening: Opening) -> tuple[bool, float]:
        return opening.has_lintel, _width_m(opening, cell_m)

    best: dict[tuple[int, int], Opening] = {}
    for opening in openings:
        best[opening.rooms] = max(best.get(opening.rooms, opening), opening, key=rank)
    return [
        opening
        for opening in openings
        if opening.has_lintel
        or opening is best[opening.rooms]
        or min(opening.rooms) == 0  # several rooms may lie behind it
        or not (sees_lintels or _width_m(opening, cell_m) < MIN_DOOR_WIDTH_M)
    ]


def _width_m(opening: Opening, cell_m: float) -> float:
    return float(np.hypot(*(opening.ends_rc[1] - opening.ends_rc[0]))) * cell_m


def _solid(free: Mask, cell_m: float) -> Mask:
    """Return ``free`` without stray rays."""
    return _opened(free, _SOLID_WIDTH_M, cell_m)


def _opened(mask: Mask, width_m: float, cell_m: float) -> Mask:
    return opened(mask, max(1, round(width_m / cell_m)))


def _grown(mask: Mask, reach_m: float, cell_m: float) -> Mask:
    """Return the cells within ``reach_m`` of ``mask``, in the maximum norm."""
    return grown(mask, round(reach_m / cell_m))


def _to_walls(free: Mask, wall: Mask, cell_m: float) -> Mask:
    """
    Return ``free (H, W)`` with the rim before ``wall`` that no ray proves to be free.

    A gap without returns between two free spaces stays: a wall seen only at grazing angles.
    """
    known = closed(free | wall, max(1, round(_RIM_M / cell_m)))
    return free | known & ~wall & _grown(wall, _RIM_REACH_M, cell_m)


def _to_faces(
    labels: NDArray[np.int32], cells: NDArray[np.int8], held: Mask | None, cell_m: float
) -> NDArray[np.int32]:
    """
    Return ``labels (H, W)`` with rooms grown into cells with returns that are not ``held``.

    Returns scatter around a wall's face, so the face lies inside the cells: in their middle where
    only one face was seen, with unseen space behind. There noise or drift spreads the returns, and
    rooms grow a second time.
    """
    wall = cells == OCCUPIED if held is None else (cells == OCCUPIED) & ~held
    unseen = cells == UNKNOWN
    one_face = _grown(unseen, _ONE_FACE_M, cell_m) & ~_grown(unseen, _SCATTER_M, cell_m)
    steps = round(_SCATTER_M / cell_m)
    labels = spread(labels, wall, square(3), steps)
    return spread(labels, wall & one_face, square(3), steps)


def _scores(labels: NDArray[np.int32], unseen: Mask) -> dict[int, RoomScore]:
    """Return the completeness of every room in ``labels (H, W)``; beyond the grid is unseen."""
    scores: dict[int, RoomScore] = {}
    for label, window in label_windows(labels).items():
        # The rectangle around a rotated room exceeds its axis-aligned window by less than half of
        # the window's shorter side.
        margin = 1 + min(s.stop - s.start for s in window) // 2
        wide = tuple(
            slice(
                max(s.start - margin, -_BEYOND_CELLS), min(s.stop + margin, size + _BEYOND_CELLS)
            )
            for s, size in zip(window, labels.shape, strict=True)
        )
        scores[label] = _score(labels, label, unseen, window, (wide[0], wide[1]))
    return scores


def _score(
    labels: NDArray[np.int32], label: int, unseen: Mask, window: Window, wide: Window
) -> RoomScore:
    """
    Score the room in a window of ``labels`` and ``unseen (H, W)``.

    The hidden part is estimated as the unseen cells in the smallest rectangle around the room that
    are reachable from its outline without crossing a wall, within ``wide``.
    """
    near = (
        slice(window[0].start - 1, window[0].stop + 1),
        slice(window[1].start - 1, window[1].stop + 1),
    )
    room = cropped(labels, near, 0) == label
    rim = grown(room, 1) & ~room
    frontier = rim & cropped(unseen, near, True)
    reached = cells_of(frontier) + np.array([near[0].start, near[1].start])
    seen = float(np.count_nonzero(room))
    hidden = float(_hidden(room, near, unseen, wide, reached)) if len(reached) else 0.0
    return RoomScore(
        observed_fraction=seen / (seen + hidden),
        frontier_fraction=len(reached) / max(1.0, float(np.count_nonzero(rim))),
    )


def _hidden(
    room: Mask, near: Window, unseen: Mask, wide: Window, reached: NDArray[np.int64]
) -> int:
    """
    Count the unseen cells in the rectangle around a room that are connected to ``reached``.

    ``room (h, w)`` lies in the window ``near``, ``reached (K, 2)`` are cells of ``unseen (H, W)``.
    """
    rows = np.flatnonzero(room.any(axis=1))
    first = room[rows].argmax(axis=1)
    last = room.shape[1] - 1 - room[rows, ::-1].argmax(axis=1)
    sides = np.stack([np.r_[first, last], np.r_[rows, rows]], axis=1)
    corner = np.array([wide[1].start, wide[0].start])
    sides += (near[1].start, near[0].start) - corner
    corners = np.rint(cv2.boxPoints(cv2.minAreaRect(sides.astype(np.int32)))).astype(np.int64)
    low = np.maximum(corners.min(axis=0) + corner, corner)
    high = np.minimum(corners.max(axis=0) + corner + 1, (wide[1].stop, wide[0].stop))
    inner = slice(int(low[1]), int(high[1])), slice(int(low[0]), int(high[0]))
    box = np.zeros((inner[0].stop - inner[0].start, inner[1].stop - inner[1].start), np.uint8)
    cv2.fillConvexPoly(box, (corners + corner - low).astype(np.int32), 1)
    box &= cropped(unseen, inner, True).view(np.uint8)
    is_within = ((reached >= low[::-1]) & (reached < high[::-1])).all(axis=1)
    return _flooded(box, reached[is_within] - low[::-1])


def _flooded(cells: NDArray[np.uint8], starts: NDArray[np.int64]) -> int:
    """Count the ones of ``cells (H, W)`` connected to ``starts (K, 2)``, and clear them."""
    count, left = 0, starts
    while len(left := left[cells[tuple(left.T)] > 0]):
        row, col = left[0].tolist()
        count += cv2.floodFill(cells, None, (col, row), 0, flags=8)[0]
    return count


def _drop_glimpses(labels: NDArray[np.int32], cell_m: float) -> NDArray[np.int32]:
    """Return ``labels (H, W)`` without rooms whose wide part is too small."""
    least = _MIN_SUBMAP_ROOM_AREA_M2 / cell_m**2
    side = max(1, round(MIN_ROOM_WIDTH_M / cell_m))
    ends, sizes, _ = label_extents(labels, int(labels.max(initial=0)) + 1)
    keep = np.zeros(len(sizes), np.int32)
    # Smaller rooms cannot have a large enough part.
    for label in (np.flatnonzero(sizes[1:] >= least) + 1).tolist():
        r0, c0, r1, c1 = ends[label].tolist()
        window = slice(r0, r1), slice(c0, c1)
        # Squares are much faster than discs; where squares fit, discs do too. This decides most.
        keep[label] = label * (
            _has_squares(labels, label, window, side, least)
            or np.count_nonzero(opened(labels[window] == label, side)) >= least
        )
    return looked_up(labels, keep)


def _has_squares(
    labels: NDArray[np.int32], label: int, window: Window, side: int, least: float
) -> bool:
    """Return whether squares of ``side`` cells fit around ``least`` or more cells of a room."""
    (rows, cols), reach, count = window, side // 2, 0
    for first in range(rows.start, rows.stop, _STRIP_CELLS):
        near = slice(first - reach, first + _STRIP_CELLS + reach)
        room = cropped(labels, (near, slice(cols.start - 1, cols.stop + 1)), 0) == label
        count += int(np.count_nonzero(shrunk(room, reach)[reach : -reach or None]))
        if count >= least:
            return True
    return False
