# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Synthetic drawings, turned by odd angles, against their known rooms and doors."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.geometry import SE2
from fpnet_core.segmentation import (
    estimate_metres_per_unit,
    segment_floorplan,
    segment_unknown_scale,
)
from fpnet_core.types import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    GridMap,
    RegionLabel,
)

CONFIG = SegmentationConfig()
RESOLUTION_M = 0.05
# Rooms (x0, y0, x1, y1) of a small office [m]; 0.2 m walls in between, corridor first.
ROOMS = [
    (0.0, 4.2, 16.0, 6.0),
    (0.0, 0.0, 5.0, 4.0),
    (5.2, 0.0, 8.4, 4.0),
    (8.6, 0.0, 16.0, 4.0),
    (0.0, 6.2, 7.0, 11.0),
    (7.2, 6.2, 16.0, 11.0),
]
# Door (x0, y0, x1, y1) passages, each through its wall.
DOORS = [
    (2.0, 3.9, 2.9, 4.3),
    (6.0, 3.9, 6.9, 4.3),
    (12.0, 3.9, 12.9, 4.3),
    (3.0, 5.9, 3.95, 6.3),
    (8.0, 5.9, 8.95, 6.3),
    (14.0, 5.9, 14.95, 6.3),
    (6.9, 8.0, 7.3, 8.9),
]
DOOR_ROOMS = [(0, 1), (0, 2), (0, 3), (0, 4), (0, 5), (0, 5), (4, 5)]


def rectangle(x0, y0, x1, y1):
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


def draw(T_grid_plan, free=(), solid=(), size=(440, 520), paper=False, scale=1.0):
    """Raster of free and then solid polygons [m], drawn with sixteenth-cell precision."""
    cells = np.full(size, FREE if paper else OCCUPIED, dtype=np.uint8)

    def fill(polygon, value):
        xy = T_grid_plan.apply(polygon * scale) / RESOLUTION_M - 0.5
        cv2.fillPoly(cells, [np.rint(xy * 16).astype(np.int32)], int(value), shift=4)

    if paper:
        fill(rectangle(-0.3, -0.3, 16.3, 11.3), OCCUPIED)
    for polygon in free:
        fill(polygon, FREE)
    for polygon in solid:
        fill(polygon, OCCUPIED)
    return cells.astype(np.int8)


def office(angle_deg=0.0, solid=(), paper=False, T_frame_grid=None, scale=1.0):
    angle = np.deg2rad(angle_deg)
    middle = np.array([8.0, 5.5]) * scale
    centre = np.array([13.0, 11.0])
    turn = SE2.from_xy_yaw(0.0, 0.0, angle)
    T_grid_plan = SE2(turn.linear, centre - turn.apply(middle))
    free = [rectangle(*box) for box in ROOMS + DOORS]
    cells = draw(T_grid_plan, free, solid, paper=paper, scale=scale)
    grid = GridMap(cells, RESOLUTION_M, T_frame_grid or SE2.identity())
    return grid, grid.T_frame_grid @ T_grid_plan


def painted(grid, T_frame_plan, polygons):
    """The same drawing with polygons [m] of a value each painted over it."""
    cells = grid.cells.astype(np.uint8)
    for polygon, value in polygons:
        rc = grid.xy_to_rc(T_frame_plan.apply(polygon))
        cv2.fillPoly(cells, [np.rint(rc[:, ::-1]).astype(np.int32)], int(value))
    return replace(grid, cells=cells.astype(np.int8))


def area_of(box):
    return (box[2] - box[0]) * (box[3] - box[1])


def room_at(segmentation, T_frame_plan, box):
    """Id of the room whose label lies at the middle of a room box."""
    middle = T_frame_plan.apply(rectangle(*box).mean(axis=0))
    row, col = np.rint(segmentation.grid.xy_to_rc(middle)).astype(int)
    return segmentation.labels[row, col] - 1


@pytest.mark.parametrize('angle_deg', [0.0, 17.3, 63.9, 151.2])
@pytest.mark.parametrize('paper', [False, True])
def test_office_is_cut_into_its_rooms_and_doors_at_any_angle(angle_deg, paper):
    grid, T_frame_plan = office(
        angle_deg, paper=paper, T_frame_grid=SE2.from_xy_yaw(-31.0, 12.5, 0.7)
    )
    segmentation = segment_floorplan(grid, CONFIG)
    assert len(segmentation.rooms) == len(ROOMS)
    ids = [room_at(segmentation, T_frame_plan, box) for box in ROOMS]
    assert sorted(ids) == list(range(len(ROOMS)))
    for box, room_id in zip(ROOMS, ids, strict=True):
        room = segmentation.regions[room_id]
        assert room.area_m2 == pytest.approx(area_of(box), rel=0.06)
        middle = T_frame_plan.apply(rectangle(*box).mean(axis=0))
        assert np.hypot(*(room.centroid - middle)) < 0.12
    found = {tuple(sorted(portal.rooms)): portal for portal in segmentation.portals}
    assert len(segmentation.portals) == len(DOORS)
    for box, (a, b) in zip(DOORS, DOOR_ROOMS, strict=True):
        middle = T_frame_plan.apply(rectangle(*box).mean(axis=0))
        near = [p for p in segmentation.portals if np.hypot(*(p.ends.mean(0) - middle)) < 0.25]
        assert len(near) == 1
        assert tuple(sorted(near[0].rooms)) == tuple(sorted((ids[a], ids[b])))
        assert near[0].width_m == pytest.approx(0.93, abs=0.13)
        assert segmentation.regions[near[0].door].label is RegionLabel.DOOR
    assert set(found) == {tuple(sorted((ids[a], ids[b]))) for a, b in DOOR_ROOMS}


def test_polygons_are_counter_clockwise_and_hold_their_area():
    segmentation = segment_floorplan(office(24.0)[0], CONFIG)
    assert len(segmentation.regions) == len(ROOMS) + len(DOORS)
    for region in segmentation.regions:
        x, y = region.polygon.T
        signed = 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))
        assert signed == pytest.approx(region.area_m2, rel=0.05)


def test_furniture_changes_neither_rooms_nor_doors():
    legs = [(9.5 + 0.7 * k, 1.0 + 0.6 * (k % 3)) for k in range(8)]
    cabinets = [rectangle(2.0, 8.0, 3.2, 8.8), rectangle(13.0, 8.5, 14.4, 9.0)]
    solid = cabinets + [rectangle(x, y, x + 0.1, y + 0.1) for x, y in legs]
    clean = segment_floorplan(office(33.0)[0], CONFIG)
    furnished = segment_floorplan(office(33.0, solid)[0], CONFIG)
    assert len(furnished.rooms) == len(clean.rooms)
    assert len(furnished.doors) == len(clean.doors)
    for before, after in zip(clean.rooms, furnished.rooms, strict=True):
        assert after.area_m2 == pytest.approx(before.area_m2, rel=0.02)


@pytest.mark.parametrize('angle_deg', [0.0, 33.0])
@pytest.mark.parametrize('bar_m', [0.8, 1.2])
@pytest.mark.parametrize('leg_m', [0.3, 0.8])
def test_a_piece_of_wall_between_doorways_is_no_furniture(angle_deg, bar_m, leg_m):
    """Without it one line would cross two doorways, and none close the third."""
    rooms = [(0.0, 0.0, 8.0, 1.8), (0.0, 2.0, 3.9, 6.0), (4.1, 2.0, 8.0, 6.0)]
    left, right, low = 4.0 - bar_m / 2.0, 4.0 + bar_m / 2.0, 2.0 + leg_m
    doorways = [
        (left - 0.9, 1.7, left, 2.1),
        (right, 1.7, right + 0.9, 2.1),
        (3.8, low, 4.2, low + 0.9),
    ]
    T_grid_plan = SE2.from_xy_yaw(8.0, 4.0, np.deg2rad(angle_deg))
    free = [rectangle(*box) for box in rooms + doorways]
    segmentation = segment_floorplan(GridMap(draw(T_grid_plan, free), RESOLUTION_M), CONFIG)
    assert len(segmentation.portals) == len(doorways)
    middles = np.array([portal.ends.mean(axis=0) for portal in segmentation.portals])
    for box in doorways:
        at = T_grid_plan.apply(rectangle(*box).mean(axis=0))
        assert np.linalg.norm(middles - at, axis=1).min() < 0.3


@pytest.mark.parametrize('size', [(2.2, 1.2), (1.2, 0.8)])
def test_an_outlined_table_is_no_room_and_hides_no_door(size):
    """The large one is closed, and nobody can enter it."""
    grid, T_frame_plan = office()
    outer = rectangle(10.0, 8.0, 10.0 + size[0], 8.0 + size[1])
    inner = rectangle(10.1, 8.1, 9.9 + size[0], 7.9 + size[1])
    drawn = painted(grid, T_frame_plan, [(outer, OCCUPIED), (inner, FREE)])
    bare, found = (segment_floorplan(each, CONFIG) for each in (grid, drawn))
    assert len(found.portals) == len(DOORS)
    assert len(found.regions) == len(bare.regions)


@pytest.mark.parametrize('angle_deg', [0.0, 33.0])
@pytest.mark.parametrize(('width_m', 'is_room'), [(0.4, False), (1.0, True)])
def test_the_hollow_of_a_wall_is_no_room_and_a_shaft_is_one(width_m, is_room, angle_deg):
    """The hollow is wider where walls meet; no door leads into either."""
    grid, T_frame_plan = office(angle_deg)
    strip = rectangle(-0.4 - width_m, 0.0, -0.4, 11.0)
    corner = rectangle(-0.8 - width_m, -0.6, -0.4, 0.0)
    drawn = painted(grid, T_frame_plan, [(strip, FREE), (corner, FREE)])
    bare, found = (segment_floorplan(each, CONFIG) for each in (grid, drawn))
    assert len(found.rooms) == len(bare.rooms) + is_room
    assert len(found.portals) == len(bare.portals)


def test_corridor_with_bulges_stays_one_room():
    corridor = [rectangle(0.0, 0.0, 20.0, 1.5)]
    bulges = [rectangle(x, 1.4, x + 2.0, 2.1) for x in (2.0, 9.0, 15.0)]
    grid = GridMap(draw(SE2.from_xy_yaw(2.0, 1.0, 0.5), corridor + bulges), RESOLUTION_M)
    segmentation = segment_floorplan(grid, CONFIG)
    assert len(segmentation.rooms) == 1
    assert segmentation.portals == ()


@pytest.mark.parametrize('scale', [0.75, 0.9, 1.3])
def test_unknown_scale_is_recovered_from_the_doors(scale):
    grid, _ = office(20.0, scale=scale)
    segmentation, estimate = segment_unknown_scale(grid, CONFIG)
    assert len(segmentation.rooms) == len(ROOMS)
    assert estimate.factor * scale == pytest.approx(1.0, rel=0.2)
    assert estimate.low < 1.0 / scale < estimate.high
    largest = max(area_of(box) for box in ROOMS)
    assert segmentation.rooms[0].area_m2 == pytest.approx(largest * scale**2, rel=0.06)


@pytest.mark.parametrize('seed', [1, 2, 3])
def test_clutter_changes_no_scale(seed):
    """Three specks of 5 to 40 cm per square metre: gaps between them would pass for doors."""
    grid, _ = office(20.0)
    cells, rng = grid.cells.copy(), np.random.default_rng(seed)
    free = np.argwhere(cells == FREE)
    for row, col in free[rng.integers(len(free), size=int(3 * len(free) * RESOLUTION_M**2))]:
        size = rng.integers(1, 9)
        speck = cells[row : row + size, col : col + size]
        speck[speck == FREE] = OCCUPIED
    cluttered = GridMap(cells, RESOLUTION_M, grid.T_frame_grid)
    clean, estimate = (segment_unknown_scale(g, CONFIG)[1] for g in (grid, cluttered))
    assert estimate.factor == pytest.approx(clean.factor, rel=0.15)
    assert estimate.low < 1.0 < estimate.high


def test_scale_of_a_plan_without_doors_is_wide_and_never_sure():
    grid = GridMap(draw(SE2.from_xy_yaw(2.0, 2.0, 0.3), [rectangle(0, 0, 5, 4)]), RESOLUTION_M)
    estimate = estimate_metres_per_unit(segment_floorplan(grid, CONFIG))
    assert estimate.high > 1.4 * estimate.low
    assert not estimate.is_sure


def test_an_empty_map_says_nothing_of_its_scale():
    grid = GridMap(np.full((20, 20), UNKNOWN), RESOLUTION_M)
    estimate = estimate_metres_per_unit(segment_floorplan(grid, CONFIG))
    assert estimate.factor == pytest.approx(1.0)
    assert estimate.low < 1 / 3 < 3 < estimate.high


def test_the_scale_does_not_depend_on_the_nominal_one():
    """Twice the nominal metres, half the factor: figures are ratios of lengths."""
    grid, _ = office(20.0)
    twice = GridMap(grid.cells, 2.0 * RESOLUTION_M, grid.T_frame_grid)
    one, other = (segment_unknown_scale(g, CONFIG)[1] for g in (grid, twice))
    assert other.factor == pytest.approx(0.5 * one.factor, rel=1e-6)
    assert (other.low, other.high) == pytest.approx((0.5 * one.low, 0.5 * one.high), rel=1e-6)


@pytest.mark.parametrize('value', [FREE, OCCUPIED, UNKNOWN])
@pytest.mark.parametrize('shape', [(1, 1), (1, 40), (60, 50)])
def test_uniform_grids_give_an_empty_result_with_a_reason(value, shape):
    segmentation = segment_floorplan(GridMap(np.full(shape, value), 0.05), CONFIG)
    assert segmentation.regions == ()
    assert segmentation.portals == ()
    assert segmentation.reason


def test_random_noise_neither_fails_nor_invents_rooms():
    rng = np.random.default_rng(5)
    cells = rng.choice([FREE, OCCUPIED, UNKNOWN], size=(83, 131)).astype(np.int8)
    segmentation = segment_floorplan(GridMap(cells, 0.05), CONFIG)
    assert segmentation.regions == ()
    assert 'no room' in segmentation.reason


@pytest.mark.parametrize('angle_deg', [0.0, 33.0])
@pytest.mark.parametrize('scale', [1.0, 1.4])
def test_an_arrow_through_a_doorway_is_no_piece_of_wall(angle_deg, scale):
    """Not in a drawing either that is taken for two fifths larger."""
    rooms = [(0.0, 0.0, 9.0, 3.0), (0.0, 3.2, 4.4, 7.0), (4.6, 3.2, 9.0, 7.0)]
    doorways = [(x, 2.9, x + 1.0, 3.3) for x in (1.5, 6.5)]
    arrows = [rectangle(x + 0.45, 2.4, x + 0.55, 3.9) for x in (1.5, 6.5)]
    T_grid_plan = SE2.from_xy_yaw(8.0, 4.0, np.deg2rad(angle_deg))
    free = [rectangle(*box) for box in rooms + doorways]
    grid = GridMap(draw(T_grid_plan, free, arrows), RESOLUTION_M)
    segmentation = segment_floorplan(grid, CONFIG, scale)
    widths = [portal.width_m for portal in segmentation.portals]
    assert widths == pytest.approx([1.0, 1.0], abs=0.15)


def test_what_lies_between_the_building_and_a_frame_around_it_is_no_room():
    grid, _ = office(paper=True)
    framed = grid.cells.copy()
    framed[[3, -4], 3:-3] = OCCUPIED
    framed[3:-3, [3, -4]] = OCCUPIED
    found = segment_floorplan(replace(grid, cells=framed), CONFIG)
    assert len(found.portals) == len(DOORS)
    assert len(found.regions) == len(segment_floorplan(grid, CONFIG).regions)
