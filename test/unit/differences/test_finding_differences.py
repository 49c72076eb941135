# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Walls that are not drawn, drawn walls that are gone, shut doors: on planted maps."""

from dataclasses import replace
import json

import cv2
import numpy as np
from planted import A_BUILDING_PLAN, A_PLAN_SUBMAP, DOORS, plan_grid, submap_grid
from planted_site import GONE_WALL, OTHER_WALLS, building_xy, inside, other_storey
import pytest

from fpnet.geojson import as_geojson, write_geojson
from fpnet_core.config import FpnetConfig
from fpnet_core.differences import DifferenceKind, find_differences
from fpnet_core.differences.of_output import differences_of
from fpnet_core.geometry import Affine2D, Placements
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.prepared_maps import StageTimer, prepare_plan, prepare_submap
from fpnet_core.segmentation import SubmapSegmenter
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, LocalizerOutput, Status

BEND_PER_M = 0.02  # rad of yaw that odometry loses on each metre


def found(plan, sub, A=A_PLAN_SUBMAP):
    drawn = prepare_plan(plan, FpnetConfig())
    seen, _ = prepare_submap(submap_from_grid(sub), SubmapSegmenter(), StageTimer())
    return find_differences(drawn, seen, A)


def likely(differences, kind):
    return [piece for piece in differences.likely if piece.kind is kind]


def length(box):
    x0, y0, x1, y1 = box
    return max(x1 - x0, y1 - y0)


def sub_xy():
    """Building metres of the cells of the robot's map."""
    grid = submap_grid()
    rc = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing='ij'), axis=-1)
    plan_xy = A_PLAN_SUBMAP.apply(grid.rc_to_xy(rc))
    return building_xy_of(plan_xy)


def building_xy_of(plan_xy):
    return A_BUILDING_PLAN.apply(plan_xy)


def test_nothing_differs_where_the_drawing_is_right():
    differences = found(plan_grid(), submap_grid())
    assert [piece for piece in differences.likely if piece.is_of_drawing] == []
    assert differences.is_seen.sum() > 0.9 * (plan_grid().cells == FREE).sum()
    assert differences.confidence.max() < 0.5


def test_nothing_is_said_to_differ_while_nobody_knows_where_the_robot_is():
    seen, _ = prepare_submap(submap_from_grid(submap_grid()), SubmapSegmenter(), StageTimer())
    plan = Floorplan.prepared(plan_grid(), FpnetConfig())
    claimed = LocalizerOutput(
        1, Status.LOCALIZED, Affine2D.identity(), segmentation=seen.segmentation,
        graph=seen.graph, estimates=Placements.of([A_PLAN_SUBMAP]),
    )  # fmt: skip
    assert differences_of(claimed, plan).is_seen.any()
    for change in (
        {'status': Status.SEARCHING, 'A_plan_odom': None},
        {'segmentation': None},
        {'graph': None},
        {'estimates': Placements.empty()},
    ):
        assert differences_of(replace(claimed, **change), plan) is None


def test_walls_that_the_drawing_has_and_the_building_has_not():
    differences = found(other_storey(), submap_grid())
    missing = likely(differences, DifferenceKind.MISSING)
    total = sum(piece.length_m for piece in missing)
    assert total == pytest.approx(sum(map(length, OTHER_WALLS)), rel=0.25)
    (new,) = likely(differences, DifferenceKind.WALL)
    assert new.length_m == pytest.approx(length(GONE_WALL), rel=0.2)
    cells = building_xy(plan_grid())[differences.confidence > 0.5]
    wide = [(x0 - 0.4, y0 - 0.4, x1 + 0.4, y1 + 0.4) for x0, y0, x1, y1 in
            (*OTHER_WALLS, GONE_WALL)]  # fmt: skip
    assert np.mean([inside(cells, box) for box in wide], axis=1).sum() > 0.95


def test_ends_are_those_of_the_wall():
    (new,) = likely(found(other_storey(), submap_grid()), DifferenceKind.WALL)
    ends = building_xy_of(new.ends)
    x0, y0, x1, y1 = GONE_WALL
    np.testing.assert_allclose(ends[:, 0], (x0 + x1) / 2, atol=0.3)
    np.testing.assert_allclose(sorted(ends[:, 1]), (y0, y1), atol=0.4)


def test_a_drawn_door_that_was_seen_shut_is_no_wall():
    grid, xy = submap_grid(), sub_xy()
    x, y = DOORS[1]
    cells = grid.cells.copy()
    cells[inside(xy, (x - 0.6, y - 0.1, x + 0.6, y + 0.1))] = OCCUPIED
    differences = found(plan_grid(), replace(grid, cells=cells))
    (shut,) = likely(differences, DifferenceKind.SHUT)
    np.testing.assert_allclose(building_xy_of(shut.ends).mean(axis=0), (x, y), atol=0.2)
    assert [piece for piece in differences.likely if piece.is_of_drawing] == []


def test_a_small_thing_in_a_room_is_furniture():
    grid, xy = submap_grid(), sub_xy()
    cells = grid.cells.copy()
    cells[inside(xy, (2.0, 2.0, 2.5, 2.4))] = OCCUPIED
    differences = found(plan_grid(), replace(grid, cells=cells))
    assert likely(differences, DifferenceKind.WALL) == []
    (piece,) = differences.pieces
    assert piece.kind is DifferenceKind.FURNITURE


def labelled(grid):
    """Return the drawing with a word in a room, and a door's open leaf with its arc on a wall."""
    ink = np.zeros(grid.shape, dtype=np.uint8)
    turn = np.radians(np.arange(0.0, 91.0, 3.0))[:, None]
    hinge = np.array(DOORS[1]) - (0.45, 0.0)
    arc = hinge + 0.9 * np.hstack([np.sin(turn), np.cos(turn)])
    xy = np.vstack([(2.2, 1.8), hinge, arc])
    at = np.rint(grid.xy_to_rc(A_BUILDING_PLAN.inv().apply(xy)))[:, ::-1].astype(np.int32)
    cv2.putText(ink, 'Ward 12', at[0].tolist(), cv2.FONT_HERSHEY_SIMPLEX, 0.5, 255, 2)
    cv2.polylines(ink, [at[1:]], False, 255)
    return replace(grid, cells=np.where(ink > 127, np.int8(OCCUPIED), grid.cells))


def test_words_and_door_symbols_are_no_walls_that_are_gone():
    drawn = labelled(plan_grid())
    assert (drawn.cells != plan_grid().cells).sum() > 200
    differences = found(drawn, submap_grid())
    assert [piece for piece in differences.likely if piece.is_of_drawing] == []


def test_what_was_not_seen_says_nothing():
    grid, xy = submap_grid(), sub_xy()
    cells = grid.cells.copy()
    cells[xy[..., 0] > 8.0] = -1
    differences = found(other_storey(), replace(grid, cells=cells))
    unseen = building_xy(plan_grid())[..., 0] > 8.6
    assert not differences.is_seen[unseen].any()
    assert not (differences.confidence[unseen] > 0.0).any()


def test_the_whole_drawing_off_by_a_little_is_not_out_of_date():
    A = Affine2D(A_PLAN_SUBMAP.linear, A_PLAN_SUBMAP.translation + np.array([0.12, -0.1]))
    differences = found(plan_grid(), submap_grid(), A)
    assert [piece for piece in differences.likely if piece.is_of_drawing] == []


def test_a_map_that_odometry_has_bent_is_no_reason_to_call_the_drawing_out_of_date():
    grid = submap_grid()
    rc = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing='ij'), axis=-1)
    xy = grid.rc_to_xy(rc)
    along = xy[..., 0] - xy[..., 0].mean()
    xy[..., 1] += 0.5 * BEND_PER_M * along**2
    at = grid.xy_to_rc(xy).astype(np.float32)
    cells = cv2.remap(grid.cells, at[..., 1], at[..., 0], cv2.INTER_NEAREST, borderValue=UNKNOWN)
    differences = found(plan_grid(), replace(grid, cells=cells))
    assert np.abs(BEND_PER_M * along).max() > np.deg2rad(6.0)
    assert [piece for piece in differences.likely if piece.is_of_drawing] == []


def test_geojson_has_every_piece_with_its_confidence(tmp_path):
    differences = found(other_storey(), submap_grid())
    write_geojson(tmp_path / 'new' / 'd.geojson', differences)
    values = json.loads((tmp_path / 'new' / 'd.geojson').read_text())
    assert values == as_geojson(differences)
    assert values['type'] == 'FeatureCollection'
    assert (values['frame'], values['units']) == ('plan', 'm')
    assert len(values['features']) == len(differences.pieces) > 0
    for feature, piece in zip(values['features'], differences.pieces, strict=True):
        assert feature['properties']['kind'] == piece.kind.value
        np.testing.assert_allclose(feature['geometry']['coordinates'], piece.ends, atol=1e-3)
