# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Single checks, on values made up for them."""

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fpnet.doctor.bias import check_bias
from fpnet.doctor.examine import examine
from fpnet.doctor.motion import check_odometry
from fpnet_core.doctor import Observed, Offer, Problem, Topic, Transform
from fpnet_core.doctor.clocks import check_clocks, check_rate
from fpnet_core.doctor.frames import check_tree
from fpnet_core.doctor.observed import SeenScan
from fpnet_core.doctor.sensor import check_mount, check_returns, check_unit, is_upside_down, tilt
from fpnet_core.doctor.topics import check_qos, check_time, mismatch
from fpnet_core.geometry.pose_track import PoseTrack
from fpnet_core.io.message_types import CLOCK, GRID, ODOMETRY, POINT_CLOUD
from fpnet_core.stamps import NS_PER_S
from fpnet_lab.sim.drives.recording import make_recording
from fpnet_lab.sim.drives.visits import RecordingOptions
from fpnet_lab.sim.lidars.sensors import SENSORS

NONE = np.zeros(0, dtype=np.int64)
RELIABLE, BEST_EFFORT = Offer(), Offer(is_reliable=False)
LATCHED = Offer(is_latched=True)


def topic(name, kind, stamps_ns=NONE, heard_ns=None, **more):
    stamps = np.asarray(stamps_ns, dtype=np.int64)
    return Topic(name, kind, stamps, stamps if heard_ns is None else heard_ns, **more)


@pytest.mark.parametrize(
    ('floor', 'ceiling', 'told_m', 'expected'),
    [
        (-0.9, 1.8, None, False),
        (-0.9, 1.8, 0.9, False),
        (-0.9, None, None, False),
        (None, 1.8, None, False),  # a dome sees no floor
        (None, None, 0.9, False),
        (-1.8, 0.9, None, True),
        (-1.8, 0.9, 0.9, True),
        (None, 0.9, None, True),  # a dome that looks down
        (-1.5, 0.9, None, False),  # a tall robot below a low ceiling, as far as anybody can tell
        (-1.5, 0.9, 1.5, False),
        (-1.5, 0.9, 0.9, True),
    ],
)
def test_the_floor_is_told_from_the_ceiling(floor, ceiling, told_m, expected):
    assert is_upside_down(floor, ceiling, told_m) is expected


@pytest.mark.parametrize(
    ('counts', 'expected'), [((), []), ((0, 0), [Problem.BLIND]), ((0, 9), [])]
)
def test_scans_of_which_none_has_a_return_are_named(counts, expected):
    empty = [SeenScan('lidar', 0, np.zeros((n, 3), np.float32), None) for n in counts]
    found = check_returns(Observed(1.0, (), '/points', sweeps=tuple(empty)))
    assert [finding.problem for finding in found] == expected


@pytest.mark.parametrize(('factor', 'expected'), [(1.0, []), (100.0, [Problem.UNIT])])
def test_centimetres_for_metres_are_named(factor, expected):
    points = factor * np.array([[1.0, 0.0, 0.0], [0.0, 4.0, 0.0], [60.0, 0.0, 1.0]], np.float32)
    seen = Observed(1.0, (), '/scan', sweeps=(SeenScan('lidar', 0, points, None),))
    assert [finding.problem for finding in check_unit(seen)] == expected


@pytest.mark.parametrize('sensor', ['beams16', 'beams32', 'beams64', 'dome', 'rosette'])
def test_the_tilt_of_every_kind_of_lidar_is_measured(sensor):
    recording = make_recording(1, RecordingOptions(lidar=SENSORS[sensor]))
    points = np.concatenate([recording.scan(i).points[::8] for i in range(0, 40, 10)])
    for degrees in (0.0, 12.0):
        turned = Rotation.from_euler('yx', [0.8 * degrees, 0.6 * degrees], degrees=True)
        found = tilt(points.astype(np.float64) @ turned.as_matrix().T)
        assert np.rad2deg(found) == pytest.approx(degrees, abs=2.0)


@pytest.mark.parametrize('index', range(0, 500, 100))
def test_a_lidar_of_a_robot_that_stands_still_is_level(index):
    recording = make_recording(1, RecordingOptions(lidar=SENSORS['beams16']))
    sweep = SeenScan('lidar', 0, recording.scan(index).points, None)
    assert list(check_mount(Observed(10.0, (), '/points', sweeps=(sweep,) * 100))) == []


@pytest.mark.parametrize(
    ('offer', 'request_', 'expected'),
    [
        (RELIABLE, RELIABLE, None),
        (RELIABLE, BEST_EFFORT, None),
        (BEST_EFFORT, BEST_EFFORT, None),
        (LATCHED, RELIABLE, None),
        (LATCHED, LATCHED, None),
        (BEST_EFFORT, RELIABLE, ('best effort', 'reliable')),
        (RELIABLE, LATCHED, ('volatile', 'transient local')),
    ],
)
def test_who_hears_whom_is_as_in_dds(offer, request_, expected):
    assert mismatch(offer, request_) == expected


def test_a_map_that_is_not_latched_is_found_and_a_costmap_is_nobodys_business():
    topics = [
        topic(name, GRID, offers=(RELIABLE,)) for name in ('/map', '/ns/floorplan', '/costmap')
    ]
    found = list(check_qos(Observed(1.0, tuple(topics))))
    assert [finding.where for finding in found] == ['/map', '/ns/floorplan']
    assert {finding.problem for finding in found} == {Problem.QOS}


@pytest.mark.parametrize(
    ('offers', 'requests', 'expected'),
    [
        ((), (), []),
        ((RELIABLE,), (BEST_EFFORT,), []),
        ((RELIABLE,), (), []),
        ((), (Offer('localizer'),), ['use_sim_time is true for localizer']),
    ],
)
def test_a_clock_that_nodes_follow_and_nobody_publishes_is_found(offers, requests, expected):
    clock = topic('/clock', CLOCK, offers=offers, requests=requests)
    found = list(check_time(Observed(5.0, (clock,))))
    assert [finding.evidence.partition(',')[0] for finding in found] == expected


def _tree(edges):
    transforms = [Transform(parent, child, np.eye(4), False) for parent, child in edges]
    return list(check_tree(Observed(1.0, (), transforms=tuple(transforms))))


names = st.sampled_from('abcdefg')


@given(st.lists(st.tuples(names, names), max_size=12))
def test_a_tree_is_healthy_exactly_where_every_frame_leads_to_a_root(edges):
    parents = {}
    for parent, child in edges:
        parents.setdefault(child, set()).add(parent)
    problems = {finding.problem for finding in _tree(edges)}
    assert (Problem.PARENTS in problems) == any(len(above) > 1 for above in parents.values())
    if Problem.PARENTS not in problems:
        single = {child: next(iter(above)) for child, above in parents.items()}

        def circles(frame):
            for _ in range(len(single) + 1):
                if frame not in single:
                    return False
                frame = single[frame]
            return True

        assert (Problem.LOOP in problems) == any(circles(child) for child in single)


def test_stamps_of_zero_and_another_clock_than_the_nodes_are_found():
    stamps = np.arange(20) * 10**8
    late = topic('/points', POINT_CLOUD, stamps, stamps + 5 * 10**9)
    seen = Observed(2.0, (late,), '/points')
    assert not list(check_clocks(seen)), 'a bag may have been recorded by any clock'
    (finding,) = check_clocks(replace(seen, is_live=True))
    assert '5.0 s behind' in finding.evidence
    (finding,) = check_clocks(replace(seen, topics=(topic('/points', POINT_CLOUD, [0, 0, 0]),)))
    assert 'all zero' in finding.evidence


def test_nothing_at_all_is_a_missing_topic_and_no_more():
    (finding,) = examine(Observed(1.0, ()))
    assert (finding.problem, finding.where) == (Problem.TOPIC, 'scans')


def _moved(x, degrees):
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler('z', degrees, degrees=True).as_matrix()
    T[0, 3] = x
    return T


def test_scans_that_leap_are_not_odometry_s_fault():
    """11 m in half a second, as KISS-ICP did with a narrow view, beside good odometry."""
    stamps_ns = [k * NS_PER_S // 2 for k in range(9)]
    driven = [(stamp_ns, _moved(0.3 * k, 0.0)) for k, stamp_ns in enumerate(stamps_ns)]
    scans = [(stamp, _moved(T[0, 3] + 11.4 * (stamp > NS_PER_S), 0.0)) for stamp, T in driven]
    odometry = topic('/odom', ODOMETRY, stamps_ns, children=('base',))
    mount = Transform('base', 'lidar', np.eye(4), is_static=True)
    sweep = SeenScan('lidar', 0, np.ones((9, 3), np.float32), None)
    seen = Observed(
        4.0, (odometry,), '/points', '/odom', (mount,), (sweep,), PoseTrack.of(driven, 'base')
    )
    (finding,) = check_odometry(seen, scans)
    assert (finding.problem, finding.where) == (Problem.REGISTRATION, '/points')
    assert list(check_odometry(seen, driven)) == []


def _driven(way=1.0, mount_deg=0.0, drift_deg_per_m=0.0, gain=1.0, count=80):
    """Return motions of 0.3 m with turns, by odometry that is wrong so, and by noisy scans."""
    rng, moved = np.random.default_rng(0), []
    for k in range(count):
        turn_deg = 8.0 * np.sin(0.3 * k)
        by_scans = _moved(0.3 + rng.normal(0.0, 0.01), turn_deg + rng.normal(0.0, 0.2))
        by_odometry = _moved(0.3 * way, gain * turn_deg + 0.3 * drift_deg_per_m)
        by_odometry[:2, 3] = _moved(0.0, mount_deg)[:2, :2] @ by_odometry[:2, 3]
        moved.append((by_odometry, by_scans))
    return moved


@pytest.mark.parametrize(
    'right', [{}, {'way': 1.04, 'mount_deg': 2.0, 'drift_deg_per_m': 0.2, 'gain': 1.03}]
)
def test_wear_and_short_drives_are_no_bias(right):
    assert list(check_bias('/odom', _driven(**right))) == []
    assert list(check_bias('/odom', _driven(way=1.4, count=4))) == []
    assert list(check_bias('/odom', [(np.eye(4), np.eye(4))] * 40)) == []


@pytest.mark.parametrize(('hz', 'is_rare'), [(2.0, True), (10.0, False)])
def test_scans_that_alone_tell_the_motion_must_come_often(hz, is_rare):
    stamps_ns = [round(k * NS_PER_S / hz) for k in range(1, 20)]
    seen = Observed(10.0, (topic('/points', POINT_CLOUD, stamps_ns),), '/points')
    found = list(check_rate(seen))
    assert [finding.problem for finding in found] == [Problem.RARE] * is_rare
    assert not is_rare or '2.0 Hz' in found[0].said
    told = replace(seen, track=PoseTrack.of([(k, np.eye(4)) for k in stamps_ns]))
    assert list(check_rate(told)) == []


@pytest.mark.parametrize(
    ('wrong', 'words'),
    [
        ({'way': 1.4}, ['1.40 times the distance', 'radius']),
        ({'way': 0.8}, ['0.80 times the distance']),
        ({'mount_deg': 20.0}, ['20 degrees to one side', 'by 20 degrees']),
        ({'mount_deg': -20.0}, ['20 degrees to one side', 'by -20 degrees']),
        ({'drift_deg_per_m': 1.0}, ['0.9 degrees per metre', 'offset']),
        ({'gain': 1.3}, ['1.29 times the rotation', 'track width']),
    ],
)
def test_what_is_steadily_wrong_with_an_odometry_is_measured(wrong, words):
    (finding,) = check_bias('/odom', _driven(**wrong))
    assert (finding.problem, finding.where) == (Problem.ODOMETRY, '/odom')
    assert all(word in f'{finding.evidence} {finding.next}' for word in words), finding.said
