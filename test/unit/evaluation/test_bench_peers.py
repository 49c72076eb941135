# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench peers`` from the outside: one row for each method."""

import json

import pytest

from fpnet.cli import main
from fpnet_lab.evaluation.localization import suite
from fpnet_lab.evaluation.localization.records import Record


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
