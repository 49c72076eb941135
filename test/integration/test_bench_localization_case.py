# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One short case of the localization benchmark through everything, and its command."""

import json
from pathlib import Path

import pytest

from fpnet.cli import main
from fpnet_core.config import FpnetConfig
from fpnet_lab.baselines import correlative
from fpnet_lab.evaluation.localization import inputs
from fpnet_lab.evaluation.localization import suite as suite_module
from fpnet_lab.evaluation.localization.cases import Case, CaseKind
from fpnet_lab.evaluation.localization.inputs import MissingDataError
from fpnet_lab.evaluation.localization.runs import Job, run_case
from fpnet_lab.sim.drives.tours import TourLimits

BASELINES = {'matcher_ransac', 'branch_and_bound', 'correlative', 'monte_carlo'}


@pytest.fixture(scope='module')
def scored(tmp_path_factory):
    """A quarter of a minute in a generated house, on its plan and on another one."""
    strip = tmp_path_factory.mktemp('strips') / 'strip.png'
    case = Case(
        'short',
        'exact',
        CaseKind.GENERATED,
        'suites',
        3,
        sensor='planar',
        wrong_cases=(0,),
        has_rough_plan=True,
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(correlative, 'ROTATIONS', 4)
        patch.setattr(correlative, 'SCALES', 1)
        patch.setattr(inputs, 'LIMITS', TourLimits(rooms=2, shortest_s=10.0, longest_s=25.0))
        records = run_case(Job(case, FpnetConfig(), 0, Path('none'), strip=strip))
    return records, strip


def test_a_case_judges_every_method_on_the_right_and_on_a_wrong_plan(scored):
    records, _ = scored
    found = [(record.group, record.method) for record in records]
    assert len(found) == len(set(found))
    for group in ('exact', 'wrong_building'):
        methods = {record.method for record in records if record.group == group}
        assert methods == {'fpnet', *BASELINES}
    [rough] = [record for record in records if record.group == 'rough']
    assert (rough.method, rough.plan, rough.is_open_set) == ('fpnet', 'short rough', False)
    assert {record.is_open_set for record in records if record.group == 'exact'} == {False}


def test_the_localizer_publishes_nothing_wrong_within_a_few_metres(scored):
    records, _ = scored
    own = [r for r in records if r.method == 'fpnet' and r.group != 'rough']
    assert [record.wrong_poses for record in own] == [0, 0]
    right, wrong = own
    assert len(right.tick_ms) > 3
    assert right.add_scan_ms > 0.0
    assert right.rss_mb > 50.0
    assert wrong.poses == 0
    assert set(right.statuses) <= {'waiting', 'searching', 'ambiguous', 'localized'}


def test_the_command_reports_and_names_what_it_skipped(tmp_path, monkeypatch, capsys, scored):
    records, _ = scored

    def fake(job):
        if job.case.kind is CaseKind.LOG:
            raise MissingDataError('no logs here')
        return records

    monkeypatch.setattr(suite_module, 'run_case', fake)
    path = tmp_path / 'bench.json'
    with pytest.raises(SystemExit) as end:
        main(['bench', 'localization', '--limit', '11', '--json', str(path)])
    assert end.value.code == 0
    assert 'skipped intel: no logs here' in capsys.readouterr().out
    report = json.loads(path.read_text())
    assert set(report['groups']) == {'exact', 'rough', 'wrong_building'}
    assert set(report['baselines']) == BASELINES
    assert report['total']['runs'] == 20
    with pytest.raises(SystemExit) as end:
        main(['bench', 'localization', '--groups', 'mars'])
    assert end.value.code == 1
    assert 'unknown group' in capsys.readouterr().err
