# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from fpnet_core.sim.scan2d import (
    EMPTY,
    GLASS,
    MISS,
    SOLID,
    carve,
    cast_rays,
    mark_ends,
    walk_field,
    walk_to,
)

NO_PASS = np.zeros(4, bool)
FOUR = np.array([0.0, 0.5, 1.0, 1.5]) * np.pi


def _room(rows=20, cols=30):
    world = np.full((rows, cols), SOLID, np.uint8)
    world[2:-2, 3:-3] = EMPTY
    return world


def test_ranges_end_at_the_walls_faces():
    ranges, codes = cast_rays(_room(), 10.5, 6.25, FOUR, 100.0, NO_PASS)
    np.testing.assert_allclose(ranges, [16.5, 11.75, 7.5, 4.25], atol=1e-9)
    assert (codes == SOLID).all()


def test_oblique_rays_meet_the_wall_where_geometry_says():
    angle = np.array([0.3])
    ranges, _ = cast_rays(_room(), 10.5, 6.25, angle, 100.0, NO_PASS[:1])
    np.testing.assert_allclose(ranges, [16.5 / np.cos(0.3)], atol=1e-9)


def test_rays_beyond_reach_or_raster_miss():
    ranges, codes = cast_rays(_room(), 10.5, 6.25, FOUR, 10.0, NO_PASS)
    assert ranges[0] == MISS
    assert codes[0] == EMPTY
    assert ranges[3] == 4.25
    open_world = np.zeros((20, 30), np.uint8)
    ranges, _ = cast_rays(open_world, 10.5, 6.25, FOUR, 100.0, NO_PASS)
    assert (ranges == MISS).all()


def test_glass_stops_only_rays_that_do_not_pass():
    world = _room()
    world[:, 15] = GLASS
    angles = np.zeros(2)
    ranges, codes = cast_rays(world, 10.5, 6.25, angles, 100.0, np.array([False, True]))
    np.testing.assert_allclose(ranges, [4.5, 16.5])
    assert codes.tolist() == [GLASS, SOLID]


def test_carving_counts_crossed_cells_once_per_ray():
    free = np.zeros((20, 30), np.uint16)
    carve(free, 10.5, 6.25, FOUR[:1], np.array([5.0]))
    assert np.flatnonzero(free[6]).tolist() == [10, 11, 12, 13, 14, 15]
    assert free.sum() == 6


def test_only_marked_ends_count():
    hits = np.zeros((20, 30), np.uint16)
    mark = np.array([True, True, False, True])
    mark_ends(hits, 10.5, 6.25, FOUR, np.array([5.0, 4.0, 3.0, 100.0]), mark)
    assert hits[6, 15] == 1
    assert hits[10, 10] == 1
    assert hits.sum() == 2


def test_walks_go_around_walls_and_cut_no_corners():
    passable = np.ones((9, 9), bool)
    passable[4, :7] = False
    previous, length = walk_field(passable, 0, 0)
    walk = walk_to(previous, 9, 8, 0)
    assert walk[0].tolist() == [0, 0]
    assert walk[-1].tolist() == [8, 0]
    assert passable[walk[:, 0], walk[:, 1]].all()
    assert (np.abs(np.diff(walk, axis=0)).max(axis=1) == 1).all()
    steps = np.diff(walk, axis=0)
    for (row, col), (dr, dc) in zip(walk[:-1], steps, strict=True):
        assert passable[row + dr, col]
        assert passable[row, col + dc]
    assert length[8 * 9] == np.float32(np.hypot(*steps.T).sum())


def test_unreachable_cells_have_no_predecessor():
    passable = np.ones((5, 5), bool)
    passable[2] = False
    previous, length = walk_field(passable, 0, 0)
    assert previous[4 * 5] == -1
    assert np.isinf(length[4 * 5])
