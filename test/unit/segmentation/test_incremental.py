# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A submap that grows: equal to a segmentation from scratch, stable tracks, local work."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.config import SubmapConfig
from fpnet_core.geometry import SE2
from fpnet_core.segmentation import SubmapSegmenter, incremental, segment_submap
from fpnet_core.submaps import SubmapBuilder
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Submap
from fpnet_lab.sim.drives.recording import RecordingOptions, make_recording
from fpnet_lab.sim.drives.tours import TourLimits

SAME_IOU = 0.95
ROOM, WALL, DOOR = 80, 4, 18


def row_of_rooms(seen, corner=(0, 0), high=True):
    """Rooms of 4 x 4 m in a row, doors between them, seen up to column ``seen``."""
    count = 5
    cells = np.full((ROOM + 2 * WALL, count * (ROOM + WALL) + WALL), OCCUPIED, dtype=np.int8)
    lintel = np.zeros(cells.shape, dtype=bool)
    for k in range(count):
        left = WALL + k * (ROOM + WALL)
        cells[WALL : WALL + ROOM, left : left + ROOM] = FREE
        if k:
            door = np.s_[WALL + 30 : WALL + 30 + DOOR, left - WALL : left]
            cells[door] = FREE
            lintel[door] = high
    cells[:, seen:] = UNKNOWN
    r0, c0 = corner
    pose = SE2.from_xy_yaw(2.0 + 0.05 * c0, -1.0 + 0.05 * r0, 0.0)
    grid = GridMap(cells[r0:, c0 : min(seen + 3, cells.shape[1])], 0.05, pose, 'submap')
    lintel = (lintel & (cells == FREE))[r0:, c0:][:, : grid.shape[1]]
    return Submap(grid, lintel, np.zeros((0, 2)))


def agreement(found, truth):
    """Best intersection over union of each true room."""
    count = len(truth.rooms) + 1
    flat = found.labels.astype(np.int64) * count + truth.labels
    table = np.bincount(flat.ravel(), minlength=(len(found.rooms) + 1) * count)
    table = table.reshape(-1, count)
    both = table[1:, 1:]
    union = table[1:].sum(axis=1)[:, None] + table[:, 1:].sum(axis=0)[None] - both
    return (both / np.maximum(union, 1)).max(axis=0, initial=0.0)


@pytest.mark.parametrize('high', [True, False])
def test_a_growing_row_of_rooms_is_cut_as_from_scratch_and_keeps_its_tracks(high):
    segmenter = SubmapSegmenter()
    tracks = {}
    for seen in range(60, 424, 20):
        submap = row_of_rooms(seen, high=high)
        found, segmenter = segmenter.update(submap)
        fresh = segment_submap(submap)
        assert len(found.rooms) == len(fresh.rooms)
        assert len(found.doors) == len(fresh.doors)
        assert (agreement(found, fresh) > SAME_IOU).all()
        for room in found.rooms:
            place = int((room.polygon[:, 0].min() - 2.0) // 4.2)
            assert tracks.setdefault(place, room.track) == room.track
        assert len({region.track for region in found.regions}) == len(found.regions)
    assert len(tracks) == 5


def test_a_raster_that_grows_to_the_left_keeps_the_tracks():
    segmenter = SubmapSegmenter()
    before, segmenter = segmenter.update(row_of_rooms(300, corner=(0, 130)))
    after, _ = segmenter.update(row_of_rooms(300))
    assert {r.track for r in before.rooms} < {r.track for r in after.rooms}
    fresh = segment_submap(row_of_rooms(300))
    assert (agreement(after, fresh) > SAME_IOU).all()


def test_doors_keep_their_tracks_and_gain_the_room_behind():
    segmenter = SubmapSegmenter()
    glimpse, segmenter = segmenter.update(row_of_rooms(WALL + ROOM + WALL + 8))
    (before,) = glimpse.portals
    assert before.rooms == (0, None)
    after, _ = segmenter.update(row_of_rooms(2 * (ROOM + WALL) + WALL))
    track = glimpse.regions[before.door].track
    (same,) = [p for p in after.portals if after.regions[p.door].track == track]
    assert set(same.rooms) == {0, 1}


def test_only_rooms_beside_a_change_are_cut_again(monkeypatch):
    segmenter = SubmapSegmenter()
    before, segmenter = segmenter.update(row_of_rooms(424))
    sizes = []
    original = incremental.segment_part

    def spy(grid, *args, **options):
        sizes.append(grid.shape)
        return original(grid, *args, **options)

    monkeypatch.setattr(incremental, 'segment_part', spy)
    submap = row_of_rooms(424)
    cells = submap.grid.cells.copy()
    cells[20:40, 20:40] = OCCUPIED  # in the first room
    after, _ = segmenter.update(replace(submap, grid=replace(submap.grid, cells=cells)))
    (size,) = sizes
    assert size[1] < 0.4 * submap.grid.shape[1]
    by_track = {room.track: room for room in after.rooms}
    unchanged = [
        r
        for r in before.rooms
        if by_track[r.track].polygon is r.polygon
        or np.array_equal(by_track[r.track].polygon, r.polygon)
    ]
    assert len(unchanged) >= 4


def test_flicker_is_ignored_until_it_adds_up(monkeypatch):
    segmenter = SubmapSegmenter()
    submap = row_of_rooms(424)
    _, segmenter = segmenter.update(submap)
    cuts = []
    original = incremental.segment_part
    monkeypatch.setattr(
        incremental, 'segment_part', lambda *a, **k: cuts.append(1) or original(*a, **k)
    )
    cells = submap.grid.cells.copy()
    for step, cell in enumerate([(30, 30), (30, 33), (33, 30), (33, 33), (36, 36), (36, 30)]):
        cells[cell] = OCCUPIED
        grid = replace(submap.grid, cells=cells.copy())
        _, segmenter = segmenter.update(replace(submap, grid=grid))
        assert step > 1 or not cuts
    assert cuts


def test_a_submap_that_empties_gives_a_reason():
    segmenter = SubmapSegmenter()
    submap = row_of_rooms(424)
    _, segmenter = segmenter.update(submap)
    gone = replace(submap.grid, cells=np.full(submap.grid.shape, UNKNOWN, dtype=np.int8))
    empty, _ = segmenter.update(Submap(gone, submap.lintel & False, np.zeros((0, 2))))
    assert empty.regions == ()
    assert empty.reason


def test_a_recording_is_cut_as_from_scratch_at_every_step():
    options = RecordingOptions(
        family='double_corridor',
        rooms=(8, 20),
        limits=TourLimits(rooms=3, shortest_s=15.0, longest_s=60.0),
    )
    recording = make_recording(7, options, threads=1)
    builder, segmenter = SubmapBuilder(SubmapConfig()), SubmapSegmenter()
    same, kept, tracks = [], [], None
    for index in range(0, min(len(recording), 320), 8):
        scan = recording.scan(index)
        builder.add_scan(scan.points, scan.T_truth_sensor, scan.stamp_ns)
        if index % 32 == 0:
            submap = builder.take()
            found, segmenter = segmenter.update(submap)
            fresh = segment_submap(submap)
            same.extend(agreement(found, fresh) >= SAME_IOU)
            now = {room.track for room in found.rooms}
            if tracks:
                kept.append(len(tracks & now) / len(tracks))
            tracks = now
    assert np.mean(same) >= 0.95
    assert np.mean(kept) >= 0.95


def test_a_turned_or_coarser_raster_starts_anew():
    segmenter = SubmapSegmenter()
    submap = row_of_rooms(424)
    found, segmenter = segmenter.update(submap)
    first = {r.track for r in found.regions}
    grid = GridMap(submap.grid.cells, 0.06, submap.grid.T_frame_grid, 'submap')
    second, _ = segmenter.update(Submap(grid, submap.lintel, np.zeros((0, 2))))
    assert len(second.rooms) == 5
    assert not first & {r.track for r in second.regions}
