# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Partial maps: unseen space, glimpses through doors, lintels."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.geometry import SE2
from fpnet_core.segmentation import segment_submap
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Submap


def two_rooms(seen=None, lintel=False, door=(40, 58)):
    """Rooms of 6 x 4 m and 4 x 4 m side by side; ``seen`` keeps a mask of cells (100, 260)."""
    cells = np.full((100, 260), UNKNOWN, dtype=np.int8)
    cells[8:92, 8:232] = OCCUPIED
    cells[10:90, 10:130] = FREE
    cells[10:90, 134:230] = FREE
    cells[door[0] : door[1], 130:134] = FREE
    if seen is not None:
        cells[~seen] = UNKNOWN
    high = np.zeros(cells.shape, dtype=bool)
    high[door[0] : door[1], 130:132] = lintel
    grid = GridMap(cells, 0.05, SE2.from_xy_yaw(4.0, -2.0, 0.37), 'submap')
    return Submap(grid, high & (cells == FREE), np.zeros((0, 2)))


def seen_left(columns):
    mask = np.zeros((100, 260), dtype=bool)
    mask[:, :columns] = True
    return mask


def test_fully_seen_rooms_have_no_frontier():
    segmentation = segment_submap(two_rooms())
    assert [round(room.area_m2) for room in segmentation.rooms] == [24, 19]
    assert all(room.observed_fraction == 1.0 for room in segmentation.rooms)
    assert all(room.frontier_fraction == 0.0 for room in segmentation.rooms)
    (portal,) = segmentation.portals
    assert portal.rooms in {(0, 1), (1, 0)}
    assert not portal.has_lintel


def test_half_seen_room_knows_its_frontier():
    seen = np.ones((100, 260), dtype=bool)
    seen[:, 185:] = False
    segmentation = segment_submap(two_rooms(seen))
    left, right = segmentation.rooms
    assert left.frontier_fraction == 0.0
    assert 0.15 < right.frontier_fraction < 0.45
    assert right.area_m2 == pytest.approx(51 * 80 * 0.05**2, rel=0.05)


def test_corner_cut_off_by_unseen_space_lowers_the_observed_fraction():
    rows, cols = np.mgrid[:100, :260]
    segmentation = segment_submap(two_rooms(~((rows - 10) + (cols - 134) > 110)))
    right = segmentation.rooms[1]
    hidden = 1.0 - right.observed_fraction
    truly_hidden = 1.0 - right.area_m2 / (96 * 80 * 0.05**2)
    assert hidden == pytest.approx(truly_hidden, abs=0.08)


def test_a_glimpse_is_dropped_and_its_door_stays():
    seen = seen_left(136)
    rows, cols = np.mgrid[:100, :260]
    fan = (cols >= 134) & (cols < 230) & (np.abs(rows - 49) < 3 + 0.02 * (cols - 134))
    segmentation = segment_submap(two_rooms(seen | fan))
    assert len(segmentation.rooms) == 1
    assert [portal.rooms for portal in segmentation.portals] == [(0, None)]


@pytest.mark.parametrize('door', [(40, 58), (20, 68)])
def test_a_lintel_closes_its_doorway_even_where_it_is_wide(door):
    segmentation = segment_submap(two_rooms(lintel=True, door=door))
    assert len(segmentation.rooms) == 2
    (portal,) = segmentation.portals
    assert portal.has_lintel
    assert set(portal.rooms) == {0, 1}
    assert portal.width_m == pytest.approx((door[1] - door[0]) * 0.05, abs=0.1)
    submap = two_rooms(lintel=True, door=door)
    middle = submap.grid.rc_to_xy([(door[0] + door[1] - 1) / 2, 131.5])
    assert portal.ends.mean(axis=0) == pytest.approx(middle, abs=0.15)


def test_the_wide_opening_without_a_lintel_is_a_door_where_walls_end_at_it():
    with_jambs = segment_submap(two_rooms(door=(20, 68)))
    assert len(with_jambs.rooms) == 2
    (portal,) = with_jambs.portals
    assert portal.width_m == pytest.approx(2.4, abs=0.15)
    without = segment_submap(two_rooms(door=(10, 90)))
    assert len(without.rooms) == 1


def redrawn(submap, window, value, path=0):
    """The submap with the cells of a window set to a value, and a path of so many places."""
    cells = submap.grid.cells.copy()
    cells[window] = value
    return Submap(replace(submap.grid, cells=cells), submap.lintel, np.zeros((path, 2)))


@pytest.mark.parametrize(('half_width', 'rooms'), [(2, 2), (7, 1)])
def test_a_piece_of_wall_between_two_doorways_stays_and_a_cabinet_does_not(half_width, rooms):
    piece = np.s_[28:72, 132 - half_width : 132 + half_width]
    submap = redrawn(two_rooms(door=(10, 90)), piece, OCCUPIED)
    assert len(segment_submap(submap).rooms) == rooms


def test_a_wall_without_returns_parts_rooms():
    submap = redrawn(two_rooms(door=(10, 90)), np.s_[10:90, 131:133], UNKNOWN, path=1)
    assert len(segment_submap(submap).rooms) == 2


def test_high_returns_inside_a_room_close_nothing():
    submap = two_rooms()
    high = np.zeros(submap.grid.shape, dtype=bool)
    high[30:34, 60:90] = True
    high[10:12, 20:60] = True
    shelf = Submap(submap.grid, high, submap.path_xy)
    segmentation = segment_submap(shelf)
    assert [portal.has_lintel for portal in segmentation.portals] == [False]
    assert len(segmentation.rooms) == 2


def test_speckle_does_not_make_regions():
    rng = np.random.default_rng(7)
    submap = two_rooms()
    cells = submap.grid.cells.copy()
    cells[rng.random(cells.shape) < 0.01] = OCCUPIED
    outside = (cells == UNKNOWN) & (rng.random(cells.shape) < 0.05)
    cells[outside] = FREE
    noisy = GridMap(cells, 0.05, submap.grid.T_frame_grid)
    segmentation = segment_submap(submap_from_grid(noisy))
    assert [round(room.area_m2) for room in segmentation.rooms] == [24, 19]


@pytest.mark.parametrize('value', [OCCUPIED, UNKNOWN])
def test_nothing_free_gives_a_reason(value):
    grid = GridMap(np.full((7, 9), value), 0.05)
    segmentation = segment_submap(submap_from_grid(grid))
    assert segmentation.regions == ()
    assert segmentation.reason


def test_a_small_free_patch_is_no_room():
    cells = np.full((40, 40), UNKNOWN, dtype=np.int8)
    cells[10:20, 10:20] = FREE
    segmentation = segment_submap(submap_from_grid(GridMap(cells, 0.05)))
    assert segmentation.regions == ()
    assert segmentation.reason


def test_where_noise_or_drift_spreads_returns_of_one_face_the_room_ends_in_their_middle():
    drawn = two_rooms()
    cells = drawn.grid.cells.copy()
    # The wall between both rooms has two faces, and no unseen space behind either.
    cells[6:10, 8:232] = cells[90:94, 8:232] = OCCUPIED
    grid = replace(drawn.grid, cells=cells)
    rooms = segment_submap(Submap(grid, drawn.lintel, np.zeros((1, 2)))).rooms
    assert rooms[0].area_m2 == pytest.approx(122 * 84 * 0.05**2, rel=0.005)
