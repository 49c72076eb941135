# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A library proposes the plan that what was seen is a part of, however it lies."""

from dataclasses import replace
import json

import cv2
import numpy as np
import pytest

from fpnet.library import PlanLibrary, plan_of
from fpnet.library.files import plan_files, share_of
from fpnet.library.keypoints import KeypointKind, keypoints_of
from fpnet_core.errors import LibraryError
from fpnet_core.geometry import SE2
from fpnet_core.segmentation import STATED_SCALE, ScaleEstimate
from fpnet_core.types import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    GridMap,
    Portal,
    Region,
    RegionLabel,
    Segmentation,
)

CELL_M = 0.1
L_ROOM = np.array([[0, 0], [6, 0], [6, 3], [3, 3], [3, 5], [0, 5]], dtype=np.float64)


def building(rng, rooms=14):
    """Rooms in a row, each of its own size, with a door to the next one."""
    lefts = np.concatenate([[0.0], np.cumsum(rng.uniform(2.0, 6.0, rooms))])
    depths = rng.uniform(2.5, 7.0, rooms)
    outlines = [
        np.array([[x0, 0.0], [x1, 0.0], [x1, y], [x0, y]])
        for x0, x1, y in zip(lefts, lefts[1:], depths, strict=False)
    ]
    doors = [
        np.array([[x, y], [x, y + 0.9]])
        for x, y in zip(lefts[1:-1], rng.uniform(0.2, 1.5, rooms), strict=False)
    ]
    return outlines, doors


def cut(outlines, doors, yaw=0.0, shift=(0.0, 0.0), scale=1.0):
    """Return a segmentation of these, turned, moved and in other units."""
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])

    def placed(points):
        return (points @ turn.T + shift) / scale

    rooms = [
        Region(i, RegionLabel.ROOM, placed(ring), placed(ring).mean(axis=0), 1.0)
        for i, ring in enumerate(outlines)
    ]
    leaves = [
        Region(len(rooms) + i, RegionLabel.DOOR, placed(L_ROOM), placed(ends).mean(axis=0), 1.0)
        for i, ends in enumerate(doors)
    ]
    portals = [
        Portal(leaf.id, (0, None), placed(ends)) for leaf, ends in zip(leaves, doors, strict=True)
    ]
    grid, labels = drawn(
        [room.polygon for room in rooms], [portal.ends for portal in portals], CELL_M / scale
    )
    return Segmentation(grid, labels, (*rooms, *leaves), tuple(portals))


def drawn(rings, openings, cell):
    """Return walls around rooms as a raster, and which cells are whose."""
    points = np.concatenate([np.zeros((1, 2)), *rings])
    low = points.min(axis=0) - 10 * cell
    size = np.ceil(np.ptp(points, axis=0) / cell).astype(int) + 20
    cells, labels = np.full(size[::-1], UNKNOWN, np.int8), np.zeros(size[::-1], np.int32)

    def pixels(points):
        return np.rint((points - low) / cell).astype(np.int32)[:, None]

    for i, ring in enumerate(rings):
        cv2.fillPoly(labels, [pixels(ring)], i + 1)
        cv2.fillPoly(cells, [pixels(ring)], FREE)
    for ring in rings:
        cv2.polylines(cells, [pixels(ring)], True, OCCUPIED)
    for ends in openings:
        cv2.polylines(cells, [pixels(ends)], False, FREE)
    labels[cells != FREE] = 0
    return GridMap(cells, cell, SE2.from_xy_yaw(*low.tolist(), 0.0)), labels


def plan(name, outlines, doors, known=STATED_SCALE, **lying):
    return plan_of(name, cut(outlines, doors, **lying), known)


def part(outlines, doors):
    return outlines[4:9], doors[4:8]


@pytest.fixture(scope='module')
def buildings():
    rng = np.random.default_rng(5)
    return [building(rng) for _ in range(40)]


@pytest.fixture(scope='module')
def library(buildings):
    plans = [plan(f'plan-{i}', *each, yaw=0.3 * i) for i, each in enumerate(buildings)]
    return PlanLibrary.of(plans)


def test_an_l_shaped_room_has_five_corners_into_it_and_one_around_it():
    found = keypoints_of(cut([L_ROOM], []))
    assert np.bincount(found.kind, minlength=3).tolist() == [0, 5, 1]
    reflex = found.xy[found.kind == KeypointKind.REFLEX] + L_ROOM.mean(axis=0)
    assert np.allclose(reflex, [[3.0, 3.0]], atol=0.01)
    # Its walls run on to the right and upwards: the corner points between them, out of the room.
    assert np.isclose(
        found.angle[found.kind == KeypointKind.REFLEX] % (2 * np.pi), np.pi / 4, atol=0.01
    )


def test_the_building_of_a_part_is_proposed_first_however_it_lies(buildings, library):
    for number in (0, 13, 39):
        seen = cut(*part(*buildings[number]), yaw=-1.0 - number, shift=(5.0, 70.0))
        proposals = library.find(seen, STATED_SCALE)
        assert proposals[0].path == f'plan-{number}'
        assert [each.rank for each in proposals] == list(range(1, len(proposals) + 1))
        assert proposals[0].fit > 1.5 * proposals[1].fit


def test_a_map_whose_scale_is_not_known_is_tried_at_all_that_are_possible(buildings, library):
    seen = cut(*part(*buildings[7]), yaw=1.0, scale=1.35)  # 1.35 true metres a nominal one
    unsure = ScaleEstimate(1.1, 0.85, 1.45)
    assert library.find(seen, unsure)[0].path == 'plan-7'
    assert all(each.path != 'plan-7' or each.rank > 1 for each in library.find(seen, STATED_SCALE))


def test_plans_of_unknown_scale_are_found_among_those_that_state_theirs(buildings, library):
    plans = [plan(f'plan-{i}', *each) for i, each in enumerate(buildings[:-1])]
    small = plan('drawn', *buildings[-1], ScaleEstimate(1.0, 0.7, 1.4), scale=1.2)
    mixed = PlanLibrary.of([*plans, small])
    assert len(mixed.parts) == 2
    assert mixed.find(cut(*part(*buildings[-1]), yaw=0.5), STATED_SCALE)[0].path == 'drawn'


def test_a_map_of_which_one_room_was_cut_is_found_by_its_walls(buildings, library):
    ranks = []
    for number in range(12):
        seen = cut(*part(*buildings[number]), yaw=1.0 + number)
        one = replace(seen, regions=seen.rooms[:1], portals=(), labels=seen.labels == 1)
        proposals = library.find(one, STATED_SCALE)
        ranks += [each.rank for each in proposals if each.path == f'plan-{number}']
    assert ranks.count(1) >= 11  # 7 by keypoints alone


def test_nothing_seen_proposes_nothing(library):
    assert library.find(cut([], []), STATED_SCALE) == ()


def test_what_is_saved_answers_alike(library, buildings, tmp_path):
    library.save(tmp_path / 'lib')
    again = PlanLibrary.open(tmp_path / 'lib')
    seen = cut(*part(*buildings[21]))
    assert again.find(seen, STATED_SCALE) == library.find(seen, STATED_SCALE)
    assert again.size_bytes == library.size_bytes
    assert isinstance(again.parts[0].shard.plan, np.memmap)


def test_shares_that_were_built_apart_are_one_library(buildings, tmp_path):
    paths = [f'plan-{i}' for i in range(len(buildings))]
    for k in (1, 2, 3):
        chosen, first = share_of(paths, f'{k}/3')
        plans = [plan(path, *buildings[paths.index(path)]) for path in chosen]
        PlanLibrary.of(plans).save(tmp_path, first)
    whole = PlanLibrary.open(tmp_path)
    assert len(whole) == len(buildings)
    for number in (0, 1, 2):
        assert whole.find(cut(*part(*buildings[number])), STATED_SCALE)[0].path == f'plan-{number}'


@pytest.mark.parametrize('share', ['0/3', '4/3', '3', 'a/b', '1/0'])
def test_a_share_that_is_none_is_said(share):
    with pytest.raises(LibraryError, match='expected K/N'):
        share_of(['plan'], share)


@pytest.mark.parametrize(
    'damage',
    [
        lambda shard: (shard / 'plan.npy').unlink(),
        lambda shard: (shard / 'plan.npy').write_bytes(b'none'),
        lambda shard: np.save(shard / 'starts.npy', np.zeros(3, np.int64)),
        lambda shard: np.save(shard / 'plan.npy', np.load(shard / 'plan.npy') + np.uint32(1000)),
        lambda shard: np.save(shard / 'kind.npy', np.load(shard / 'kind.npy') + np.uint8(9)),
        lambda shard: (shard / 'plans.json').write_text('{}'),
        lambda shard: (shard / 'plans.json').write_text(json.dumps({'format': 99, 'plans': []})),
        lambda shard: (shard / 'plans.json').write_text(json.dumps({'format': 2, 'plans': []})),
    ],
)
def test_a_damaged_library_is_refused_and_says_what_to_do(library, tmp_path, damage):
    library.save(tmp_path)
    damage(tmp_path / 'shard-00000')
    with pytest.raises(LibraryError, match='build'):
        PlanLibrary.open(tmp_path)


def test_a_library_of_an_older_format_is_refused_by_its_number(library, tmp_path):
    library.save(tmp_path)
    shard = tmp_path / 'shard-00000'
    manifest = json.loads((shard / 'plans.json').read_text())
    (shard / 'plans.json').write_text(json.dumps(manifest | {'format': 1}))
    (shard / 'walls.npy').unlink()  # there were none
    with pytest.raises(LibraryError, match='has format 1; build the library again'):
        PlanLibrary.open(tmp_path)


def test_walls_of_a_plan_that_were_damaged_are_said_where_they_are_asked_for(
    library, buildings, tmp_path
):
    library.save(tmp_path)
    path = tmp_path / 'shard-00000' / 'walls.npy'
    np.save(path, np.zeros_like(np.load(path)))
    damaged = PlanLibrary.open(tmp_path)
    with pytest.raises(LibraryError, match='build the library again'):
        damaged.find(cut(*part(*buildings[3])), STATED_SCALE)


def test_a_folder_without_a_library_says_how_to_make_one(tmp_path):
    with pytest.raises(LibraryError, match='fpnet library build'):
        PlanLibrary.open(tmp_path / 'none')


def test_plans_are_found_at_any_depth_and_an_image_beside_its_yaml_is_no_other_one(tmp_path):
    (tmp_path / 'deep').mkdir()
    names = ('a.png', 'deep/b.pdf', 'deep/c.yaml', 'deep/c.png', 'notes.txt')
    for name in names:
        (tmp_path / name).write_bytes(b'')
    found = [str(path.relative_to(tmp_path)) for path in plan_files([tmp_path])]
    assert found == ['a.png', 'deep/b.pdf', 'deep/c.yaml']
    (tmp_path / 'empty').mkdir()
    with pytest.raises(LibraryError, match='holds no floorplan'):
        plan_files([tmp_path / 'empty'])
    with pytest.raises(LibraryError, match='does not exist'):
        plan_files([tmp_path / 'missing.png'])


def test_what_lies_beside_a_map_is_no_other_plan_and_other_yamls_are_none(tmp_path, caplog):
    (tmp_path / 'map.yaml').write_text('image: floor.pgm\nresolution: 0.05\n')
    (tmp_path / 'camera.yaml').write_text('camera:\n  image: topic\n')
    (tmp_path / 'bag').mkdir()
    (tmp_path / 'bag' / 'metadata.yaml').write_text('rosbag2_bagfile_information: {}\n')
    for name in ('floor.pgm', 'map_reading.png', 'map.pdf', 'other_reading.png'):
        (tmp_path / name).write_bytes(b'')
    found = [path.name for path in plan_files([tmp_path])]
    assert found == ['map.yaml', 'other_reading.png']
    assert ['camera.yaml' in said and 'metadata.yaml' in said for said in caplog.messages] == [
        True
    ]
