# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Benchmarks on planted outcomes: demos, methods, submaps, storeys apart, growth."""

from dataclasses import replace
import json
import math

import numpy as np
import pytest
import shapely

from fpnet.cli import main
from fpnet.recordings.trajectories import write_tum
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.pose import map_evidence
from fpnet_core.segmentation import segment_submap
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Submap
from fpnet_lab.evaluation.demo import rate_demo
from fpnet_lab.evaluation.localization import suite
from fpnet_lab.evaluation.localization.records import Record
from fpnet_lab.evaluation.sites.storeys_apart import Parting
from fpnet_lab.evaluation.speed import growth
from fpnet_lab.evaluation.submap_recordings import RegisteredDrive
from fpnet_lab.evaluation.submap_segmentation import score_segmentation, summary
from fpnet_lab.sim.drawn.distort import DrawnPlan
from fpnet_lab.sim.plans.wards import wards
from fpnet_lab.sim.types import BuildingPlan, PlanDoor, PlanRoom
from fpnet_lab.viz.growth import save_growth

START_NS = 1_750_000_000_000_000_000
PERIOD_NS = 100_000_000
# The drawing is stretched unevenly and turned by 40 degrees.
A_PLAN_BUILDING = SE2.from_xy_yaw(5.0, -3.0, math.radians(40.0)) @ Affine2D(
    np.diag([1.04, 0.97]), np.zeros(2)
)


def _truth():
    stamps = START_NS + PERIOD_NS * np.arange(100)
    xy = np.column_stack([0.1 * np.arange(100), np.full(100, 2.0)])
    return stamps, xy, np.full(100, 0.3)


def _write(tmp_path, published, updates=()):
    recording, session = tmp_path / 'recording', tmp_path / 'session'
    session.mkdir()
    write_tum(recording / 'truth.tum', *_truth())
    matrix = A_PLAN_BUILDING.matrix[:2].tolist()
    (recording / 'truth.json').write_text(json.dumps({'A_plan_building': matrix}))
    write_tum(session / 'poses.tum', *published)
    facts = {'scans': 100, 'registered_scans': 99, 'ticks': list(updates)}
    (session / 'session.json').write_text(json.dumps(facts))
    return recording, session


def _published(first: int, off_m=(0.0, 0.0), off_rad: float = 0.0):
    """Poses from ``first`` on, wrong by the given true metres and radians."""
    stamps, xy, yaw = _truth()
    in_plan = A_PLAN_BUILDING.apply(xy + off_m)
    yaw_in_plan = [A_PLAN_BUILDING.apply_yaw(angle + off_rad) for angle in yaw]
    return stamps[first:], in_plan[first:], np.array(yaw_in_plan)[first:]


def test_errors_are_in_true_metres_and_degrees(tmp_path):
    updates = [{'status': 'waiting'}, {'total_ms': 100.0}, {'total_ms': 300.0}]
    published = _published(30, (0.3, -0.4), math.radians(2.0))
    run = rate_demo(*_write(tmp_path, published, updates))
    result = run.as_json()
    assert result['localized'] is True
    assert run.is_success
    assert result['poses'] == 70
    assert result['wrong_poses'] == 0
    assert result['time_to_first_pose_s'] == pytest.approx(3.0)
    assert result['path_to_first_pose_m'] == pytest.approx(3.0)
    assert result['median_position_error_m'] == pytest.approx(0.5, abs=1e-3)
    assert result['median_yaw_error_deg'] == pytest.approx(2.0, abs=1e-2)
    assert result['tick_ms_p50'] == pytest.approx(200.0)
    assert (result['scans'], result['registered_scans']) == (100, 99)


@pytest.mark.parametrize(('off_m', 'off_deg'), [((3.1, 0.0), 0.0), ((0.0, 0.0), 31.0)])
def test_a_wrong_place_or_heading_is_no_success(tmp_path, off_m, off_deg):
    run = rate_demo(*_write(tmp_path, _published(90, off_m, math.radians(off_deg))))
    assert run.summary.localized
    assert run.summary.wrong_poses == 10
    assert not run.is_success


def test_no_pose_is_no_success(tmp_path):
    run = rate_demo(*_write(tmp_path, _published(100)))
    assert run.summary.poses == 0
    assert not run.summary.localized
    assert not run.is_success
    assert run.as_json()['median_position_error_m'] is None


@pytest.mark.parametrize(
    ('name', 'content', 'message'),
    [
        ('poses.tum', b'\x80', 'not text'),
        ('session.json', b'{}', 'ticks'),
        ('session.json', b'{"ticks": 3}', 'session'),
        ('session.json', b'{"ticks": [], "scans": null}', 'session'),
        ('session.json', b'[]', 'session'),
    ],
)
def test_damaged_files_are_named(tmp_path, name, content, message):
    recording, session = _write(tmp_path, _published(0))
    (session / name).write_bytes(content)
    with pytest.raises(FpnetError, match=message):
        rate_demo(recording, session)


def record(case, method, is_right):
    return Record(
        case=case, group='exact', building='suites', sensor='planar', seed=0, method=method,
        plan='own', is_open_set=False, is_right=is_right, is_tight=is_right, poses=10,
        wrong_poses=0 if is_right else 4, path_to_first_pose_m=3.0, median_position_error_m=0.1,
        median_yaw_error_deg=1.0, beliefs=(), tick_ms=(20.0,), add_scan_ms=1.0, rss_mb=1.0,
    )  # fmt: skip


def test_the_command_counts_right_and_wrong_of_each_method(tmp_path, monkeypatch, capsys):
    def fake(job):
        assert job.with_baselines
        return record(job.case.name, 'fpnet', True), record(job.case.name, 'rival', False)

    monkeypatch.setattr(suite, 'run_case', fake)
    path = tmp_path / 'peers.json'
    with pytest.raises(SystemExit) as ended:
        main(['bench', 'peers', '--limit', '3', '--maps', '0', '--json', str(path)])
    assert not ended.value.code
    assert '3 recordings' in capsys.readouterr().out
    report = json.loads(path.read_text())
    ours, theirs = (report['methods'][name] for name in ('fpnet', 'rival'))
    assert (ours['runs'], ours['right'], ours['claimed_right']) == (3, 3, 3)
    assert (theirs['right'], theirs['claimed_wrong']) == (0, 3)
    assert ours['look_s'] == pytest.approx(0.02)
    assert report['made']['commit']


T_BUILDING_ODOM = SE2.from_xy_yaw(7.0, -3.0, 0.5)


def box(x0, y0, x1, y1):
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)


PLAN = BuildingPlan(
    rooms=(PlanRoom(box(0, 0, 6, 4)), PlanRoom(box(6.2, 0, 10.2, 4)), PlanRoom(box(20, 0, 24, 4))),
    doors=(
        PlanDoor((0, 1), np.array([[6.1, 1.6], [6.1, 2.5]])),
        PlanDoor((1, 2), np.array([[15.0, 1.6], [15.0, 2.5]])),
    ),
    wall_m=0.2,
    family='drawn',
)


def submap(seen_m=11.0):
    """Both near rooms as the robot saw them up to x = seen_m, in a turned odometry frame."""
    cells = np.full((100, 240), UNKNOWN, dtype=np.int8)
    cells[8:92, 8:216] = OCCUPIED
    cells[10:90, 10:130] = FREE
    cells[10:90, 134:214] = FREE
    cells[42:60, 130:134] = FREE
    cells[:, 10 + round(seen_m / 0.05) :] = UNKNOWN
    T_odom_grid = T_BUILDING_ODOM.inv() @ SE2.from_xy_yaw(-0.5, -0.5, 0.0)
    grid = GridMap(cells, 0.05, T_odom_grid, 'submap')
    return Submap(grid, np.zeros(cells.shape, dtype=bool), np.zeros((0, 2)))


def drive():
    return RegisteredDrive(PLAN, T_BUILDING_ODOM, ())


def score(sub):
    return score_segmentation(segment_submap(sub), drive(), 'drawn', 0)


def test_a_right_segmentation_scores_nearly_one():
    result = score(submap())
    assert result.room_ious == pytest.approx([1.0, 1.0], abs=0.06)
    assert tuple(result.doors) == (1, 1, 1, 1)


def test_unseen_parts_and_glimpsed_rooms_do_not_count():
    assert score(submap(seen_m=9.0)).room_ious == pytest.approx([1.0, 1.0], abs=0.06)
    assert len(score(submap(seen_m=7.0)).room_ious) == 1


def test_a_missed_wall_costs_a_room_and_its_door():
    sub = submap()
    cells = sub.grid.cells.copy()
    cells[10:90, 130:134] = FREE
    joined = Submap(GridMap(cells, 0.05, sub.grid.T_frame_grid, 'submap'), sub.lintel, sub.path_xy)
    result = score(joined)
    assert sorted(result.room_ious) == pytest.approx([0.0, 0.58], abs=0.04)
    assert tuple(result.doors) == (0, 0, 1, 0)


def test_summary_weighs_rooms_and_doors_not_drives():
    figures = summary([score(submap()), score(submap(seen_m=7.0))])
    assert figures['rooms'] == 3
    assert figures['recordings'] == 2
    assert figures['rooms_over_iou50'] == 1.0
    assert figures['doors_recall'] == 1.0
    assert summary([])['room_iou_mean'] == 0.0


CELL_M = 0.05
MARGIN_M = 1.0
WALL_M = 2.0
T_SUBMAP_BUILDING = SE2.from_xy_yaw(-3.0, 7.0, 0.4)


def hall(*walls):
    """Return a hall of 8 by 12 m; inner walls of 2 m stand so many metres from its west side."""
    cells = np.full((160, 240), FREE, dtype=np.int8)
    cells[:2], cells[-2:], cells[:, :2], cells[:, -2:] = (OCCUPIED,) * 4
    for x in walls:
        cells[: round(WALL_M / CELL_M), round(x / CELL_M) : round(x / CELL_M) + 2] = OCCUPIED
    return GridMap(np.pad(cells, round(MARGIN_M / CELL_M), constant_values=UNKNOWN), CELL_M)


def drawn(grid, x, y, yaw):
    T_plan_building = SE2.from_xy_yaw(x, y, yaw)
    return DrawnPlan(replace(grid, T_frame_grid=T_plan_building @ grid.T_frame_grid),
                     T_plan_building)  # fmt: skip


def parting(own, other):
    return Parting.of(drawn(hall(*own), 5.0, -2.0, 1.1), drawn(hall(*other), -9.0, 4.0, 2.6))


def seen(grid, until_m=12.0):
    """Return the evidence of a submap that ends ``until_m`` from the west, in its own frame."""
    cells = grid.cells.copy()
    cells[:, round((MARGIN_M + until_m) / CELL_M) :] = UNKNOWN
    T_frame_grid = T_SUBMAP_BUILDING @ grid.T_frame_grid
    return map_evidence(replace(grid, cells=cells, T_frame_grid=T_frame_grid))


def test_equal_drawings_are_never_told_apart():
    assert parting([4.0], [4.0]).seen_m(seen(hall(4.0)), T_SUBMAP_BUILDING) == 0.0


@pytest.mark.parametrize(('own', 'other'), [([4.0, 8.0], [4.0]), ([4.0], [4.0, 8.0])])
def test_a_wall_tells_once_it_is_seen_or_seen_not_to_be_there(own, other):
    apart = parting(own, other)
    length_m = apart.seen_m(seen(hall(*own)), T_SUBMAP_BUILDING)
    assert 0.6 * WALL_M < length_m < 2.5 * WALL_M  # it has two sides, and an end in the wall
    assert apart.seen_m(seen(hall(*own), until_m=7.5), T_SUBMAP_BUILDING) == 0.0


STOREY = growth.Grown(
    20_000.0, 423, 3173.0, (3.0, 1.5), (0.6, 0.4), {'segment': 0.3, 'match': 0.2}, 10**9, 'waiting'
)


@pytest.mark.parametrize('area_m2', [300.0, 2_000.0, 8_000.0])
def test_wards_have_the_size_that_is_asked_for(area_m2):
    plan = wards(np.random.default_rng(0), area_m2)
    assert 0.75 * area_m2 < plan.floor_area_m2 < 1.15 * area_m2
    assert len(plan.rooms) == pytest.approx(area_m2 / 50.0, rel=0.35)
    outlines = [room.polygon for room in plan.rooms]
    union = shapely.union_all([shapely.Polygon(outline) for outline in outlines])
    assert union.area == pytest.approx(plan.floor_area_m2, rel=1e-3)


def test_a_small_storey_is_measured_and_drawn(tmp_path):
    found = growth.growth(300.0)
    assert found.explored_m2 > 50.0
    assert 0.0 < found.update[1] < 60.0
    assert found.peak_bytes > 5e7
    save_growth([found, STOREY], tmp_path / 'growth.png')
    assert (tmp_path / 'growth.png').stat().st_size > 10_000
