# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The localizer driven with planar scans of the planted building."""

from dataclasses import replace

import numpy as np
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import SCAN_NS, drive, recorded
import pytest

from fpnet_core.config import FpnetConfig, load_config
from fpnet_core.errors import CloudFormatError, MapFormatError, OdometryError, StateError
from fpnet_core.geometry import SE2, angle_between
from fpnet_core.localizer import Localizer
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.state import read_state, write_state
from fpnet_core.matches import MatchResult
from fpnet_core.scoring.reasons import NO_PLAN, NOT_LOOKED
from fpnet_core.types import GridMap, Status


class IndifferentMatcher:
    """Holds every pair for equally likely, so that the raster alone has to decide."""

    def match(self, plan, sub, explored_area_m2):
        shape = (len(plan), len(sub))
        return MatchResult(np.zeros((0, 2)), np.zeros(0), np.full(shape, 0.01))


def new_localizer(**overrides):
    localizer = Localizer(load_config(None, overrides), IndifferentMatcher())
    localizer.set_plan(plan_grid())
    return localizer


def outputs_of(localizer, scans, tick_every=5):
    outputs = []
    for index, (points, T_odom_sensor, stamp_ns) in enumerate(scans):
        localizer.add_scan(points, T_odom_sensor, stamp_ns)
        if index % tick_every == tick_every - 1:
            outputs.append(localizer.update(stamp_ns))
    return outputs


def run(localizer, scans, tick_every=5):
    return [output.status for output in outputs_of(localizer, scans, tick_every)]


@pytest.fixture(scope='module')
def finished():
    localizer = new_localizer()
    assert localizer.output.reason == NOT_LOOKED
    outputs = outputs_of(localizer, recorded())
    assert all(output.reason for output in outputs)
    return localizer, [output.status for output in outputs]


def test_it_waits_then_finds_the_robot(finished):
    _, statuses = finished
    assert statuses[0] is Status.AMBIGUOUS  # one room, as good in others
    assert set(statuses[1:]) == {Status.LOCALIZED}


def test_a_firm_claim_is_followed_without_a_search_until_one_is_due():
    localizer = new_localizer(**{'localizer.search_every_updates': 4})
    run(localizer, recorded())
    points, T_odom_sensor, stamp_ns = recorded()[-1]
    searched = []
    for number in range(1, 9):
        localizer.add_scan(points, T_odom_sensor, stamp_ns + number * SCAN_NS)
        output = localizer.update(stamp_ns + number * SCAN_NS)
        assert output.status is Status.LOCALIZED
        assert output.segmentation is not None
        assert output.match is not None
        searched.append('match' in output.timings_ms)
    assert sum(searched) == 2
    assert searched[:4] == searched[4:]
    localizer.relocalize()
    localizer.add_scan(points, T_odom_sensor, stamp_ns + 9 * SCAN_NS)
    assert 'match' in localizer.update(stamp_ns + 9 * SCAN_NS).timings_ms, 'a claim was forgotten'


def test_the_pose_is_right_on_the_drawing(finished):
    localizer, _ = finished
    x, y, yaw = drive()[-1]
    first = SE2.from_xy_yaw(*drive()[0])
    T_odom_sensor = first.inv() @ SE2.from_xy_yaw(x, y, yaw)
    pose = localizer.output.pose(T_odom_sensor.as_matrix4())
    in_building = A_BUILDING_PLAN.apply(pose.translation)
    assert np.linalg.norm(in_building - (x, y)) < 0.2
    assert angle_between(pose.yaw + A_BUILDING_PLAN.yaw, yaw) < np.deg2rad(2.0)


def test_the_same_calls_give_the_same_answer(finished):
    localizer, statuses = finished
    again = new_localizer()
    assert run(again, recorded()) == statuses
    np.testing.assert_array_equal(
        again.output.A_plan_odom.matrix, localizer.output.A_plan_odom.matrix
    )


def test_without_a_plan_it_says_so():
    localizer = Localizer(FpnetConfig(), IndifferentMatcher())
    assert localizer.output.reason == NO_PLAN
    assert localizer.update(1).status is Status.NO_PLAN
    assert localizer.output.reason == NO_PLAN
    assert localizer.output.pose(np.eye(4)) is None


def test_without_scans_it_waits():
    output = new_localizer().update(1)
    assert output.status is Status.WAITING
    assert output.reason == 'only 0 of 12 m² of floor observed so far'


def test_a_plan_without_rooms_is_refused_and_the_old_one_stays():
    localizer = new_localizer()
    before = localizer.plan
    with pytest.raises(MapFormatError, match='contains no room'):
        localizer.set_plan(GridMap(np.full((50, 50), 100, dtype=np.int8), 0.05))
    assert localizer.plan is before


@pytest.mark.parametrize(
    ('pose', 'message'),
    [
        (np.eye(3), r'expected a \(4, 4\) matrix, got shape \(3, 3\)'),
        (np.full((4, 4), np.nan), 'finite'),
        (np.diag([1.0, 1.0, 2.0, 1.0]), 'expected a rigid transform'),
        (np.diag([1.0, -1.0, 1.0, 1.0]), 'expected a rigid transform'),
    ],
)
def test_a_pose_that_is_none_is_refused(pose, message):
    with pytest.raises(OdometryError, match=message):
        new_localizer().add_scan(np.zeros((10, 3), np.float32), pose, 1)


def test_bad_points_are_refused_and_the_submap_is_kept():
    localizer = new_localizer()
    scans = recorded()[:20]
    run(localizer, scans)
    area = localizer.update(1).submap.free_area_m2
    with pytest.raises(CloudFormatError):
        localizer.add_scan(np.zeros((10, 2), np.float32), np.eye(4), 10**12)
    assert localizer.update(2).submap.free_area_m2 == area


def test_a_stale_scan_is_dropped_and_a_lasting_clock_reset_starts_anew():
    localizer = new_localizer(**{'localizer.stale_scans_before_restart': 3})
    scans = recorded()[:10]
    run(localizer, scans)
    points, pose, _ = scans[0]
    for _ in range(2):
        with pytest.raises(OdometryError, match='not newer'):
            localizer.add_scan(points, pose, 1)
    localizer.add_scan(points, pose, 1)
    assert localizer.update(2).submap.stamp_ns == 1


def test_an_odometry_jump_starts_a_new_submap():
    localizer = new_localizer()
    scans = recorded()[:20]
    run(localizer, scans)
    before = localizer.update(0).submap
    points, _, stamp_ns = scans[-1]
    far = SE2.from_xy_yaw(50.0, 0.0, 0.0).as_matrix4()
    localizer.add_scan(points, far, stamp_ns + SCAN_NS)
    assert localizer.output.reason == 'new submap: odometry jumped by 44.25 m'
    after = localizer.update(0).submap
    assert len(after.path_xy) == 1 < len(before.path_xy)


def test_a_robot_that_is_carried_off_is_noticed_and_found_again():
    """Its odometry goes on as if nothing had happened; the robot is back at the start."""
    localizer = new_localizer()
    scans = recorded()
    assert run(localizer, scans)[-1] is Status.LOCALIZED
    (_, T_odom_first, _), (_, T_odom_last, last_ns) = scans[0], scans[-1]
    T_new_old = T_odom_last @ np.linalg.inv(T_odom_first)
    again = [(points, T_new_old @ T, last_ns + SCAN_NS + stamp) for points, T, stamp in scans]
    localizer.add_scan(*again[0])
    assert localizer.output.status is Status.WAITING, 'at the first scan'
    assert localizer.output.reason.startswith('new submap: the newest scans contradict the pose')
    assert 'kidnapped' in localizer.output.reason
    assert run(localizer, again[1:])[-1] is Status.LOCALIZED
    x, y, _ = drive()[-1]
    in_building = A_BUILDING_PLAN.apply(localizer.output.pose(again[-1][1]).translation)
    assert np.linalg.norm(in_building - (x, y)) < 0.2


def test_a_claim_never_outlives_its_plan(finished):
    localizer, _ = finished
    assert localizer.output.status is Status.LOCALIZED
    localizer.set_plan(plan_grid())
    assert localizer.output.A_plan_odom is None
    assert localizer.output.pose(np.eye(4)) is None


def hint_at(index, off_m=0.0):
    """Return somebody's word on where the robot was at a scan, so far off eastward."""
    _, T_odom_sensor, _ = recorded()[index]
    truth = A_BUILDING_PLAN.inv()
    x, y, yaw = drive()[index]
    east, north = truth.apply((x, y))
    said = SE2.from_xy_yaw(east + off_m, north, truth.apply_yaw(yaw))
    return PoseHint(said, SE2.from_matrix4(T_odom_sensor))


@pytest.mark.parametrize('off_m', [0.0, 1.5, 3.0, 500.0])
def test_a_claim_stands_whatever_anybody_says_against_the_walls(off_m, caplog):
    localizer = new_localizer()
    assert run(localizer, recorded()[:40])[-1] is Status.LOCALIZED
    claimed = localizer.output.A_plan_odom
    localizer.suggest(hint_at(39, off_m))
    assert localizer.output.A_plan_odom is claimed, 'TF goes on meanwhile'
    assert localizer.update(0).status is Status.LOCALIZED, 'standing still it is weighed as well'
    assert set(run(localizer, recorded()[40:], tick_every=1)) == {Status.LOCALIZED}
    assert caplog.text.count('no placement fits near the pose hint') == int(off_m > 2.0)


@pytest.mark.parametrize('off_m', [0.0, 1.5])
def test_a_right_hint_never_makes_less_sure(off_m):
    localizer = new_localizer()
    run(localizer, recorded()[:40])
    localizer.relocalize()
    localizer.suggest(hint_at(39, off_m))
    assert localizer.output.A_plan_odom is None
    statuses = run(localizer, recorded()[40:], tick_every=1)
    assert statuses[0] is Status.AMBIGUOUS, 'a claim takes two looks'
    assert set(statuses[1:]) == {Status.LOCALIZED}


@pytest.mark.parametrize('off_m', [3.0, 500.0])
def test_a_wrong_hint_is_said_once_and_outweighed(off_m, caplog):
    localizer = new_localizer()
    run(localizer, recorded()[:40])
    localizer.relocalize()
    localizer.suggest(hint_at(39, off_m))
    statuses = run(localizer, recorded()[40:], tick_every=1)
    assert caplog.text.count('no placement fits near the pose hint') == 1
    assert statuses[-1] is Status.LOCALIZED
    first = statuses.index(Status.LOCALIZED)
    assert set(statuses[first:]) == {Status.LOCALIZED}, 'nothing near it unseats the claim'


def test_a_restarted_odometry_takes_the_placement_along(finished):
    localizer = new_localizer()
    scans = recorded()
    run(localizer, scans)
    known = localizer.output.A_plan_odom
    points, T_odom_sensor, stamp_ns = scans[-1]
    localizer.restart_odometry()
    localizer.add_scan(points, np.eye(4), stamp_ns + SCAN_NS)  # odometry starts at its origin
    assert localizer.output.A_plan_odom is None
    output = localizer.update(0)
    assert len(output.submap.path_xy) == 1
    best = output.estimates[0].A_plan_submap @ output.submap.T_odom_submap.inv()
    expected = known.apply(SE2.from_matrix4(T_odom_sensor).translation)
    assert np.linalg.norm(best.translation - expected) < 0.5


@pytest.fixture(scope='module')
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp('state') / 'new' / 'state.npz'
    localizer = new_localizer()
    run(localizer, recorded()[:-5])
    localizer.save_state(path, 'run 7')
    return localizer, path


class TestSavedState:
    def test_another_process_goes_on_where_the_first_one_was(self, saved):
        first, path = saved
        second = Localizer(load_config(), IndifferentMatcher())
        second.load_state(path)
        second.set_plan(plan_grid())
        for localizer in (first, second):
            for points, T_odom_sensor, stamp_ns in recorded()[-5:]:
                localizer.add_scan(points, T_odom_sensor, stamp_ns)
                localizer.update(stamp_ns)
        np.testing.assert_array_equal(
            first.output.submap.grid.cells, second.output.submap.grid.cells
        )
        assert first.output.status is second.output.status is Status.LOCALIZED
        A, B = first.output.A_plan_odom, second.output.A_plan_odom
        np.testing.assert_allclose(A.matrix, B.matrix, atol=0.05)

    def test_after_a_restart_of_odometry_the_submap_is_left_and_the_place_tried_first(self, saved):
        first, path = saved
        second = Localizer(load_config(), IndifferentMatcher())
        assert second.load_state(path) == 'run 7'
        second.restart_odometry()
        points, _, stamp_ns = recorded()[-6]
        second.add_scan(points, np.eye(4), stamp_ns + SCAN_NS)  # before the floorplan comes
        second.set_plan(plan_grid())
        output = second.update(0)
        assert len(output.submap.path_xy) == 1, 'nothing of the saved submap'
        best = output.estimates[0].A_plan_submap @ output.submap.T_odom_submap.inv()
        last = SE2.from_matrix4(recorded()[-6][1]).translation
        expected = first.output.A_plan_odom.apply(last)
        assert np.linalg.norm(best.translation - expected) < 0.5

    def test_a_claim_is_not_restored(self, saved):
        second = new_localizer()
        second.load_state(saved[1])
        assert second.output.status is Status.WAITING
        assert second.output.pose(np.eye(4)) is None

    def test_another_configuration_or_a_damaged_file_is_refused(self, saved, tmp_path):
        coarse = new_localizer(**{'submap.resolution_m': 0.1})
        with pytest.raises(StateError, match='resolution_m'):
            coarse.load_state(saved[1])
        damaged = tmp_path / 'damaged.npz'
        damaged.write_bytes(saved[1].read_bytes()[:-200])
        with pytest.raises(StateError, match='not a saved state'):
            new_localizer().load_state(damaged)
        with pytest.raises(StateError, match='not a saved state'):
            new_localizer().load_state(tmp_path / 'absent.npz')
        with np.load(saved[1]) as file:
            arrays = {name: file[name] for name in file.files}
        for change, said in (
            (('"version": 3', '"version": 2'), 'version 2, expected 3'),
            (('"odometry"', '"extra"'), 'extra'),
            (('[4, 4]', '[2, 8]'), 'T_odom_sensor'),
        ):
            tree = str(arrays['tree'])
            assert change[0] in tree
            np.savez(damaged, **{**arrays, 'tree': np.array(tree.replace(*change))})
            with pytest.raises(StateError, match=said):
                new_localizer().load_state(damaged)
        state = read_state(saved[1])
        submap = {**state.submap, 'counts': np.zeros((3, 3))}
        write_state(damaged, replace(state, submap=submap))
        with pytest.raises(StateError, match='ray counts'):
            new_localizer().load_state(damaged)

    def test_there_is_nothing_to_save_before_the_first_scan(self, tmp_path):
        with pytest.raises(StateError, match='no scan'):
            new_localizer().save_state(tmp_path / 'state.npz')


def test_odometry_that_jumps_to_and_fro_is_told_once(caplog):
    localizer = new_localizer()
    points, T_odom_sensor, _ = recorded()[0]
    far = SE2.from_xy_yaw(50.0, 0.0, 0.0).as_matrix4()
    for index in range(8):
        pose = far @ T_odom_sensor if index % 2 else T_odom_sensor
        localizer.add_scan(points, pose, index * SCAN_NS)
    assert sum('starting a new submap' in record.message for record in caplog.records) == 1
