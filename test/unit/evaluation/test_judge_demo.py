# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import json
import math

import numpy as np
import pytest

from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.io.trajectories import write_tum
from fpnet_lab.evaluation.demo import rate_demo

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
