# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Incremental segmentation of a growing submap: only rooms near changed cells are segmented again.

Cells are compared with those of the last segmentation of each room. Where enough of them differ,
the nearby rooms are *touched*: they are segmented again as a whole, together with all space that
is no room yet, in a window around them. All other rooms are *held*: their walls and clearance
count in the window, but their cells stay, and doors between a held and a touched room keep their
place. Single cells that flicker at the edge of the seen area touch nothing until they add up. A
segmentation from scratch may differ by such cells, and by effects that reach through a held room;
the tests bound the difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.blocks import block_counts, unblocked
from fpnet_core.raster.morphology import Mask, grown
from fpnet_core.raster.pieces import looked_up, shared_cells
from fpnet_core.raster.windows import Window, window_of
from fpnet_core.segmentation.lintels import Doorway
from fpnet_core.segmentation.scene import WORK_RESOLUTION_M
from fpnet_core.segmentation.submap import is_from_scans, segment_part, segment_submap
from fpnet_core.types import UNKNOWN, GridMap, Portal, Region, Segmentation, Submap

Named = TypeVar('Named', Region, Portal)

# Numerical: changes are counted in square tiles [m]. A tile is dirty from this share of changed
# cells; dirty tiles touch the rooms in them and in adjacent tiles.
_TILE_M = 0.5
_DIRTY_SHARE = 0.04  # numerical
# Numerical: cells farther from the touched rooms do not affect their segmentation: more than the
# largest piece of furniture and the widest doorway [m].
_MARGIN_M = 3.0
# Rooms whose opening has no lintel and is wider are segmented again together: the shapes of both
# rooms decide whether it divides them [m]. Chosen.
_SURE_WIDTH_M = 1.2
# A door this near to one of the last segmentation is the same door [m]. Chosen.
_SAME_DOOR_M = 0.5
# Numerical: grids of one submap are aligned to this fraction of a cell.
_ALIGNED_CELLS = 1e-3


@dataclass(frozen=True, eq=False)
class SubmapSegmenter:
    """
    Incremental segmenter of one growing submap; regions keep their ``track``.

    Immutable: each update returns the next segmenter. A room's track goes to the new room that
    shares most cells with it, a door's to the new door at its place; tracks are never reused. Any
    submap may follow any other: the comparison of cells finds the common part.

    Parameters
    ----------
    last
        Result of the last update; None before the first.
    tracks
        Number of tracks assigned so far.
    """

    last: _Last | None = None
    tracks: int = 0

    def update(self, submap: Submap) -> tuple[Segmentation, SubmapSegmenter]:
        """Return the segmentation of ``submap``, equal to a new one within small tolerances."""
        last = None if self.last is None else _moved(self.last, submap.grid)
        if last is not None:
            return self._refreshed(submap, last)
        result = segment_submap(submap)
        regions = self._named(result.regions, [None] * len(result.regions))
        result = replace(result, regions=tuple(regions))
        cut = _Last(submap.grid.cells, submap.lintel, result)
        return result, SubmapSegmenter(cut, self.tracks + len(regions))

    def _refreshed(self, submap: Submap, last: _Last) -> tuple[Segmentation, SubmapSegmenter]:
        """Return the new result, and the segmenter that remembers its source cells."""
        grid = submap.grid
        differs = (grid.cells != last.cells) | (submap.lintel != last.lintel)
        dirty = _dirty_tiles(differs, grid.resolution)
        if not dirty.any():
            return last.segmentation, replace(self, last=last)
        box, near = _dirty_cells(dirty, grid)
        met = np.bincount(last.segmentation.labels[box][near])
        touched = set((np.flatnonzero(met) - 1).tolist()) - {-1}
        touched = _with_partners(touched, last.segmentation, _SURE_WIDTH_M)
        stride = max(1, round(WORK_RESOLUTION_M / grid.resolution))
        window = _window(last.segmentation, touched, box, stride)
        kept, labels = _held(last.segmentation, touched)
        held = labels[window] > 0
        part = segment_part(
            grid.cropped(*window),
            submap.lintel[window].copy(),
            held=held,
            known_doors=_doorways([door for door in kept.doors if door.is_loose], grid, window),
            held_doors=_doorways([door for door in kept.doors if not door.is_loose], grid, window),
            has_scans=is_from_scans(submap),
            sees_lintels=bool(submap.lintel.any()),
        )
        inherited = _inherited(part, last.segmentation, touched, kept, window)
        part = replace(part, regions=tuple(self._named(part.regions, inherited)))
        seen = ~grown(held, _tile_cells(grid.resolution))
        seen[_within(box, window)] |= near
        cells, lintel = last.cells.copy(), last.lintel.copy()
        np.copyto(cells[window], grid.cells[window], where=seen)
        np.copyto(lintel[window], submap.lintel[window], where=seen)
        result = _spliced(grid, labels, kept, part, window)
        cut = _Last(cells, lintel, result)
        return result, SubmapSegmenter(cut, self.tracks + len(part.regions))

    def _named(self, regions: Sequence[Region], tracks: Sequence[int | None]) -> list[Region]:
        """Return regions with the given tracks, new ones for None."""
        fresh = iter(range(self.tracks, self.tracks + len(regions)))
        return [
            _with(region, track=next(fresh) if track is None else track)
            for region, track in zip(regions, tracks, strict=True)
        ]


@dataclass(frozen=True, eq=False)
class _Last:
    """The last segmentation, and the cells and lintels ``(H, W)`` that it was computed from."""

    cells: NDArray[np.int8]
    lintel: Mask
    segmentation: Segmentation


@dataclass(frozen=True, eq=False)
class _Door:
    """A door with the indices of its rooms in a list; None is touched or unseen space."""

    region: Region
    portal: Portal
    rooms: tuple[int | None, int | None]

    @property
    def is_loose(self) -> bool:
        return None in self.rooms


@dataclass(frozen=True, eq=False)
class _Kept:
    """Rooms that are not segmented again, and all their doors."""

    rooms: list[Region]
    doors: list[_Door]


def _moved(last: _Last, grid: GridMap) -> _Last | None:
    """Move the last result to the raster of ``grid``; return None if the grids do not align."""
    old, segmentation = last.segmentation.grid, last.segmentation
    corner = grid.xy_to_rc(old.rc_to_xy(np.zeros(2)))
    row, col = (int(k) for k in np.rint(corner))
    if (
        old.resolution != grid.resolution
        or old.T_frame_grid.yaw != grid.T_frame_grid.yaw
        or np.abs(corner - (row, col)).max() > _ALIGNED_CELLS
    ):
        return None
    if row == col == 0 and old.shape == grid.shape:
        return replace(last, segmentation=replace(segmentation, grid=grid))
    r0, c0 = max(row, 0), max(col, 0)
    r1, c1 = min(row + old.shape[0], grid.shape[0]), min(col + old.shape[1], grid.shape[1])
    if r1 <= r0 or c1 <= c0:
        return None
    here, there = np.s_[r0:r1, c0:c1], np.s_[r0 - row : r1 - row, c0 - col : c1 - col]
    cells = np.full(grid.shape, UNKNOWN, dtype=np.int8)
    lintel = np.zeros(grid.shape, dtype=np.bool_)
    labels = np.zeros(grid.shape, dtype=np.int32)
    cells[here], lintel[here] = last.cells[there], last.lintel[there]
    labels[here] = segmentation.labels[there]
    return _Last(cells, lintel, replace(segmentation, grid=grid, labels=labels))


def _dirty_tiles(differs: Mask, cell_m: float) -> Mask:
    """Return the tiles with enough changed cells, and all adjacent tiles."""
    size = _tile_cells(cell_m)
    return grown(block_counts(differs, size) >= _DIRTY_SHARE * size**2, 1)


def _tile_cells(cell_m: float) -> int:
    return max(1, round(_TILE_M / cell_m))


def _dirty_cells(dirty: Mask, grid: GridMap) -> tuple[Window, Mask]:
    """Return the window around dirty tiles, and its cells in dirty tiles."""
    size = _tile_cells(grid.resolution)
    window = window_of(dirty)
    assert window is not None, 'nothing is dirty'
    rows, cols = (
        slice(tiles.start * size, min(tiles.stop * size, limit))
        for tiles, limit in zip(window, grid.shape, strict=True)
    )
    shape = rows.stop - rows.start, cols.stop - cols.start
    return (rows, cols), unblocked(dirty[window], size, shape)


def _within(box: Window, window: Window) -> Window:
    """Return ``box`` relative to the origin of ``window``, which contains it."""
    (rows, cols), (r0, c0) = box, (window[0].start, window[1].start)
    return slice(rows.start - r0, rows.stop - r0), slice(cols.start - c0, cols.stop - c0)


def _with_partners(touched: set[int], segmentation: Segmentation, sure_width_m: float) -> set[int]:
    """Return the rooms and all rooms connected to them by wide openings without a lintel."""
    beside: dict[int, set[int]] = {}
    for portal in segmentation.portals:
        here, there = portal.rooms
        if there is not None and not (portal.has_lintel or portal.width_m <= sure_width_m):
            beside.setdefault(here, set()).add(there)
            beside.setdefault(there, set()).add(here)
    found, rest = set(touched), list(touched)
    while rest:
        new = beside.get(rest.pop(), set()) - found
        found |= new
        rest += new
    return found


def _window(segmentation: Segmentation, touched: set[int], box: Window, stride: int) -> Window:
    """
    Return the window around ``box`` and all touched rooms, with a margin.

    It begins at a multiple of ``stride`` cells, so the working blocks are those of the whole grid.
    """
    grid = segmentation.grid
    low, high = [(box[0].start, box[1].start)], [(box[0].stop, box[1].stop)]
    for room in touched:
        rc = grid.xy_to_rc(segmentation.regions[room].polygon)
        low.append(tuple(np.floor(rc.min(axis=0)).astype(int).tolist()))
        high.append(tuple(np.ceil(rc.max(axis=0)).astype(int).tolist()))
    margin = round(_MARGIN_M / grid.resolution)
    r0, c0 = (np.min(low, axis=0) - margin).tolist()
    r1, c1 = (np.max(high, axis=0) + margin).tolist()
    return (
        slice(max(r0 - r0 % stride, 0), min(r1, grid.shape[0])),
        slice(max(c0 - c0 % stride, 0), min(c1, grid.shape[1])),
    )


def _held(segmentation: Segmentation, touched: set[int]) -> tuple[_Kept, NDArray[np.int32]]:
    """Return what is kept, and labels (H, W): index of the kept room + 1."""
    rooms = [room for room in segmentation.rooms if room.id not in touched]
    place: dict[int | None, int] = {room.id: number for number, room in enumerate(rooms)}
    lookup = np.zeros(len(segmentation.rooms) + 1, dtype=np.int32)
    lookup[[room.id + 1 for room in rooms]] = np.arange(1, len(rooms) + 1)
    doors = []
    for portal in segmentation.portals:
        ends = place.get(portal.rooms[0]), place.get(portal.rooms[1])
        if ends != (None, None):
            doors.append(_Door(segmentation.regions[portal.door], portal, ends))
    return _Kept(rooms, doors), looked_up(segmentation.labels, lookup)


def _doorways(doors: Sequence[_Door], grid: GridMap, window: Window) -> list[Doorway]:
    """Return the doors inside the window, in its cells, so that they are not detected again."""
    corner = np.array([window[0].start, window[1].start])
    size = np.array([window[0].stop, window[1].stop]) - corner
    ends = _ends_rc(doors, grid) - corner
    inside = ((ends >= 0) & (ends < size - 1)).all(axis=(1, 2))
    return [
        Doorway(line, grid.resolution, door.portal.has_lintel)
        for door, line, is_inside in zip(doors, ends, inside, strict=True)
        if is_inside
    ]


def _ends_rc(doors: Sequence[_Door], grid: GridMap) -> NDArray[np.float64]:
    """Return the ends (D, 2, 2) of the doors' lines in the cells of ``grid``."""
    return grid.xy_to_rc(np.array([door.portal.ends for door in doors]).reshape(-1, 2, 2))


def _inherited(
    part: Segmentation, old: Segmentation, touched: set[int], kept: _Kept, window: Window
) -> list[int | None]:
    """Return, for each region of the part, the track of the region that it continues."""
    from scipy.optimize import linear_sum_assignment  # not needed before the second update

    tracks: list[int | None] = [None] * len(part.regions)
    shared = shared_cells(part.labels, old.labels[window].copy(), len(part.rooms), len(old.rooms))
    for new, room in zip(*linear_sum_assignment(shared, maximize=True), strict=True):
        if shared[new, room] > 0 and room in touched:
            tracks[new] = old.regions[room].track
    held = {door.region.id for door in kept.doors}
    gone = [door for door in old.doors if door.id not in held]
    if gone and part.doors:
        before, after = (np.array([d.centroid for d in doors]) for doors in (gone, part.doors))
        distance = np.hypot(*(after[:, None] - before[None]).T).T
        for i, j in zip(
            *linear_sum_assignment(np.minimum(distance, 2.0 * _SAME_DOOR_M)), strict=True
        ):
            if distance[i, j] < _SAME_DOOR_M:
                tracks[part.doors[i].id] = gone[j].track
    return tracks


def _spliced(
    grid: GridMap, labels: NDArray[np.int32], kept: _Kept, part: Segmentation, window: Window
) -> Segmentation:
    """
    Combine the part's rooms and doors with the kept ones.

    ``labels (H, W)`` are of the kept rooms; they become the result's.
    """
    first = len(kept.rooms)
    np.add(part.labels, first, out=labels[window], where=part.labels > 0)
    rooms = [*kept.rooms, *part.rooms]
    known = _middles([door.portal for door in kept.doors])
    found = []
    for portal, middle in zip(part.portals, _middles(part.portals), strict=True):
        if (np.hypot(*(known - middle).T) >= _SAME_DOOR_M).all():
            ends = tuple(None if room is None else room + first for room in portal.rooms)
            found.append(_Door(part.regions[portal.door], portal, (ends[0], ends[1])))
    doors = _relinked([*kept.doors, *found], labels, grid)
    order = sorted(range(len(rooms)), key=lambda k: (-rooms[k].area_m2, rooms[k].track))
    ids = {number: position for position, number in enumerate(order)}
    lookup = np.zeros(len(rooms) + 1, dtype=np.int32)
    lookup[np.array(order, dtype=np.int64) + 1] = np.arange(1, len(rooms) + 1)
    regions = [_with(rooms[number], id=position) for number, position in ids.items()]
    portals = []
    for door in doors:
        linked = [ids[room] for room in door.rooms if room is not None]
        portal_rooms = linked[0], (linked[1] if len(linked) == 2 else None)
        portals.append(_with(door.portal, door=len(regions), rooms=portal_rooms))
        regions.append(_with(door.region, id=len(regions)))
    reason = '' if rooms else part.reason
    labels = looked_up(labels, lookup)
    labels.setflags(write=False)  # Segmentation copies writable arrays
    return Segmentation(grid, labels, tuple(regions), tuple(portals), reason)


def _with(value: Named, **changes: object) -> Named:
    """Return a region or portal with fields replaced, without repeating its validation."""
    other = object.__new__(type(value))
    other.__dict__.update(vars(value), **changes)
    return other


def _middles(portals: Sequence[Portal]) -> NDArray[np.float64]:
    """Return the middles (D, 2) of doors [m]."""
    ends = np.array([portal.ends for portal in portals], dtype=np.float64)
    return np.asarray(ends.reshape(-1, 2, 2).mean(axis=1))


def _relinked(doors: Sequence[_Door], labels: NDArray[np.int32], grid: GridMap) -> list[_Door]:
    """Return doors, where those into unseen space link to the room that is there now, if any."""
    lines = _ends_rc(doors, grid)
    return [
        _linked(door, Doorway(ends, grid.resolution).between(labels).rooms)
        if door.is_loose
        else door
        for door, ends in zip(doors, lines, strict=True)
    ]


def _linked(door: _Door, labels: tuple[int, int]) -> _Door:
    """Return the door with the other room of ``labels`` as its second, if there are two."""
    here = next(room for room in door.rooms if room is not None)
    sides = [label - 1 for label in labels if label > 0]
    others = [room for room in sides if room != here]
    return replace(door, rooms=(here, others[0])) if here in sides and others else door
