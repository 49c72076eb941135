# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Clouds without viewpoints: storeys, furniture, lintels, blind spots and strays, all planted."""

import logging

import numpy as np
import pytest

from fpnet_core.config import SubmapConfig
from fpnet_core.errors import CloudFormatError
from fpnet_core.segmentation import segment_submap
from fpnet_core.submaps import submap_from_cloud
from fpnet_core.submaps.storeys import find_storeys, without_strays
from fpnet_core.types import FREE, OCCUPIED

WIDTH, DEPTH, HEIGHT, LINTEL, STEP = 5.0, 4.0, 2.6, 2.05, 0.04
DOOR_Y = (1.5, 2.4)
SIDE = 0.8  # of a piece of furniture


def sheet(x, y, z):
    """Return points (P, 3) over the box of three ranges; a range of no length is one value."""
    axes = [np.arange(a, b + 1e-9, STEP) if b > a else np.array([a]) for a, b in (x, y, z)]
    return np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1).reshape(-1, 3)


def storey(rooms=2, with_ceiling=True, seed=0):
    """Return rooms in a row along x, doors between them, as a cloud with a centimetre of noise."""
    length = rooms * WIDTH
    flat = [sheet((0, length), (0, DEPTH), (0, 0))]
    if with_ceiling:
        flat.append(sheet((0, length), (0, DEPTH), (HEIGHT, HEIGHT)))
    walls = [sheet((0, length), (y, y), (0, HEIGHT)) for y in (0.0, DEPTH)]
    walls += [sheet((x, x), (0, DEPTH), (0, HEIGHT)) for x in (0.0, length)]
    for number in range(1, rooms):
        for face in (number * WIDTH - 0.05, number * WIDTH + 0.05):
            wall = sheet((face, face), (0, DEPTH), (0, HEIGHT))
            is_door = (wall[:, 1] > DOOR_Y[0]) & (wall[:, 1] < DOOR_Y[1]) & (wall[:, 2] < LINTEL)
            walls.append(wall[~is_door])
    points = np.concatenate([*flat, *walls])
    return points + np.random.default_rng(seed).normal(0.0, 0.01, points.shape)


def rooms_of(points, number=None):
    return segment_submap(submap_from_cloud(points, SubmapConfig(), number))


def cell_at(submap, x, y):
    row, col = np.rint(submap.grid.xy_to_rc(np.array([x, y]))).astype(int)
    return submap.grid.cells[row, col]


def test_two_rooms_and_the_door_between_them():
    found = rooms_of(storey())
    np.testing.assert_allclose([room.area_m2 for room in found.rooms], WIDTH * DEPTH, rtol=0.06)
    (door,) = found.portals
    assert door.width_m == pytest.approx(DOOR_Y[1] - DOOR_Y[0], abs=0.12)
    np.testing.assert_allclose(door.ends.mean(axis=0), [WIDTH, np.mean(DOOR_Y)], atol=0.15)


@pytest.mark.parametrize('edge', [0.08, 0.1, 0.15])
@pytest.mark.parametrize('is_turned', [False, True])
def test_a_cloud_that_was_thinned_to_voxels_shows_the_same_rooms(edge, is_turned):
    c, s = (np.cos(0.4), np.sin(0.4)) if is_turned else (1.0, 0.0)
    points = storey() @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    thinned = (np.unique(np.floor(points / edge), axis=0) + 0.5) * edge
    found = rooms_of(thinned)
    np.testing.assert_allclose([room.area_m2 for room in found.rooms], WIDTH * DEPTH, rtol=0.12)
    (door,) = found.portals
    assert door.width_m == pytest.approx(DOOR_Y[1] - DOOR_Y[0], abs=0.25)


def test_where_the_cloud_lies_and_how_it_is_turned_does_not_matter():
    c, s = np.cos(0.4), np.sin(0.4)
    moved = storey() @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    found = rooms_of(moved + np.array([500_000.0, 5_400_000.0, 312.0]))
    np.testing.assert_allclose([room.area_m2 for room in found.rooms], WIDTH * DEPTH, rtol=0.08)


def test_a_floor_that_furniture_hides_is_free_below_the_ceiling():
    points = storey(rooms=1)
    under = (points[:, 0] > 1.0) & (points[:, 0] < 3.0) & (points[:, 1] > 1.0)
    under &= points[:, 1] < 2.5
    hidden = points[~(under & (points[:, 2] < 0.5))]
    table = sheet((1.0, 3.0), (1.0, 2.5), (0.75, 0.75))
    submap = submap_from_cloud(np.concatenate([hidden, table]), SubmapConfig())
    assert cell_at(submap, 2.0, 1.7) == FREE
    (room,) = segment_submap(submap).rooms
    assert room.area_m2 == pytest.approx(WIDTH * DEPTH, rel=0.06)


def test_a_shelf_up_to_the_ceiling_is_an_obstacle():
    shelf = sheet((2.0, 3.0), (0.425, 0.425), (0.0, 2.3))
    submap = submap_from_cloud(np.concatenate([storey(rooms=1), shelf]), SubmapConfig())
    assert cell_at(submap, 2.525, 0.425) == OCCUPIED


def test_blind_spots_of_the_scanner_are_free():
    points = storey(rooms=1)
    is_blind = np.hypot(points[:, 0] - 2.5, points[:, 1] - 2.0) < 0.9
    level = (points[:, 2] < 0.2) | (points[:, 2] > 2.4)
    submap = submap_from_cloud(points[~(is_blind & level)], SubmapConfig())
    assert cell_at(submap, 2.5, 2.0) == FREE


def test_storeys_are_told_apart_by_their_floors(caplog):
    cloud = np.concatenate(
        [storey(rooms=2), storey(rooms=3, seed=1) + np.array([0.0, 0.0, HEIGHT + 0.35])]
    )
    found = find_storeys(cloud)
    np.testing.assert_allclose([each.floor_m for each in found], [0.0, 2.95], atol=0.08)
    np.testing.assert_allclose([each.ceiling_m for each in found], [2.6, 5.55], atol=0.08)
    assert [len(rooms_of(cloud, number).rooms) for number in (1, 2)] == [2, 3]
    with caplog.at_level(logging.WARNING):
        assert len(rooms_of(cloud).rooms) == 3
    assert 'shows 2 storeys; using storey 2' in caplog.text
    with pytest.raises(CloudFormatError, match='storey 3: the cloud shows 2'):
        rooms_of(cloud, 3)


def crowded(points, share, seed=3):
    """Return a storey in which furniture of several heights covers a share of the floor."""
    rng = np.random.default_rng(seed)
    length = float(points[:, 0].max())
    pieces = []
    for x in np.arange(0.2, length - SIDE, SIDE):
        for y in np.arange(0.2, DEPTH - SIDE, SIDE):
            if rng.random() > share:
                continue
            top = 0.74 if rng.random() < 0.8 else rng.uniform(1.1, 1.9)
            below = (points[:, :2] > (x, y)).all(axis=1) & (points[:, 2] < top - 0.1)
            below &= (points[:, :2] < (x + SIDE, y + SIDE)).all(axis=1)
            points = points[~below]
            pieces.append(sheet((x, x + SIDE), (y, y + SIDE), (top, top)))
            pieces += [sheet((side, side), (y, y + SIDE), (0.05, top)) for side in (x, x + SIDE)]
    return np.concatenate([points, *pieces])


@pytest.mark.parametrize('share', [0.3, 0.5, 0.65])
@pytest.mark.parametrize('with_ceiling', [False, True])
def test_furniture_that_hides_most_of_the_floor_is_no_storey(share, with_ceiling):
    (level,) = find_storeys(crowded(storey(3, with_ceiling), share))
    assert level.floor_m == pytest.approx(0.0, abs=0.08)


@pytest.mark.parametrize('slab', [0.2, 0.35, 1.4])
@pytest.mark.parametrize('has_facade', [False, True])
def test_a_ceiling_with_the_next_floor_on_it_is_no_floor(slab, has_facade):
    low, high = (crowded(storey(2, seed=seed), 0.5) for seed in (0, 1))
    facade = sheet((0, 2.0 * WIDTH), (0, 0), (HEIGHT, HEIGHT + slab)) if has_facade else low[:0]
    cloud = np.concatenate([low, high + np.array([0.0, 0.0, HEIGHT + slab]), facade])
    found = find_storeys(cloud)
    np.testing.assert_allclose([each.floor_m for each in found], [0.0, HEIGHT + slab], atol=0.1)


@pytest.mark.parametrize('height', [-0.5, -1.0])
def test_lower_ground_around_a_building_is_not_its_floor(height):
    ground = sheet((-3.0, 2.0 * WIDTH + 3.0), (-3.0, DEPTH + 3.0), (height, height))
    inside = (ground[:, :2] > -0.3).all(axis=1)
    inside &= (ground[:, :2] < (2.0 * WIDTH + 0.3, DEPTH + 0.3)).all(axis=1)
    (level,) = find_storeys(np.concatenate([storey(), ground[~inside]]))
    assert level.floor_m == pytest.approx(0.0, abs=0.08)


def test_strays_do_not_stretch_the_raster():
    rng = np.random.default_rng(5)
    strays = rng.uniform([-60.0, -60.0, -1.0], [60.0, 60.0, 5.0], (2000, 3))
    cloud = np.concatenate([storey(), strays])
    kept = without_strays(cloud)
    assert len(storey()) <= len(kept) <= len(storey()) + 100
    assert max(submap_from_cloud(cloud, SubmapConfig()).grid.shape) < 300


def test_ground_outside_of_a_building_with_ceilings_is_dropped():
    ground = sheet((2.0 * WIDTH + 0.5, 2.0 * WIDTH + 4.0), (0, DEPTH), (0, 0))
    found = rooms_of(np.concatenate([storey(), ground]))
    assert len(found.rooms) == 2


def test_a_robot_that_saw_nothing_above_it_takes_all_that_stands_for_walls():
    low = storey()
    found = rooms_of(low[low[:, 2] < 1.7])
    np.testing.assert_allclose(sum(room.area_m2 for room in found.rooms), 40.0, rtol=0.08)
