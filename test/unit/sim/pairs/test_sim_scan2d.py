# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from fpnet_lab.sim.pairs.scan2d import (
    EMPTY,
    GLASS,
    SOLID,
    cast_rays,
    clear_cells,
    walk_field,
    walk_to,
)

FOUR = np.array([0.0, 0.5, 1.0, 1.5]) * np.pi


def _room(rows=20, cols=30):
    world = np.full((rows, cols), SOLID, np.uint8)
    world[2:-2, 3:-3] = EMPTY
    return world


def _directions(angles):
    angles = np.asarray(angles)
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)[None]


def _cast(world, angles, reach=100.0, passes=None, x=10.5, y=6.25):
    passes = np.zeros((1, len(angles)), bool) if passes is None else np.array([passes])
    starts = np.array([[x, y]])
    clear = clear_cells(world == EMPTY)
    ranges, codes = cast_rays(world[None], clear, starts, _directions(angles), reach, passes)
    return ranges[0, 0], codes[0, 0]


def test_ranges_end_at_the_walls_faces():
    ranges, codes = _cast(_room(), FOUR)
    np.testing.assert_allclose(ranges, [16.5, 11.75, 7.5, 4.25], atol=1e-9)
    assert (codes == SOLID).all()


def test_oblique_rays_meet_the_wall_where_geometry_says():
    ranges, _ = _cast(_room(), [0.3])
    np.testing.assert_allclose(ranges, [16.5 / np.cos(0.3)], atol=1e-9)


def test_leaping_over_clear_cells_changes_nothing():
    rng = np.random.default_rng(5)
    world = np.where(rng.random((120, 150)) < 0.004, SOLID, EMPTY).astype(np.uint8)
    world[58:63, 68:73] = EMPTY
    angles = rng.uniform(-np.pi, np.pi, 500)
    leaping = _cast(world, angles, x=70.4, y=60.7)
    starts, passes = np.array([[70.4, 60.7]]), np.zeros((1, 500), bool)
    no_leaps = np.zeros_like(world)
    stepping = cast_rays(world[None], no_leaps, starts, _directions(angles), 100.0, passes)
    np.testing.assert_allclose(leaping[0], stepping[0][0, 0], atol=1e-9)
    np.testing.assert_array_equal(leaping[1], stepping[1][0, 0])
    assert (leaping[1] == SOLID).any()
    assert (leaping[1] == EMPTY).any()


def test_glass_stops_only_rays_that_do_not_pass():
    world = _room()
    world[:, 15] = GLASS
    ranges, codes = _cast(world, [0.0, 0.0], passes=[False, True])
    np.testing.assert_allclose(ranges, [4.5, 16.5])
    assert codes.tolist() == [GLASS, SOLID]


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
