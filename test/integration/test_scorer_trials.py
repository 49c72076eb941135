# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trials for the judge from end to end: maps, plans, evidence, truth, and how far it is right."""

import json

import numpy as np
import pytest
from real_data import DATA, needs

from fpnet.cli import main
from fpnet_core.config import FpnetConfig
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_lab.training import scorer_drives
from fpnet_lab.training.scorer_drives import DriveSource
from fpnet_lab.training.scorer_trials import TrialSource

pytestmark = pytest.mark.slow


def matcher():
    return LearnedMatcher(FpnetConfig().matcher)


def test_generated_maps_meet_their_own_plan_and_others():
    source = TrialSource('generated', 77, None, FpnetConfig(), matcher())
    trials = [trial for index in range(6) for trial in source.trials(index)]
    own = [trial for trial in trials if trial.is_own]
    foreign = [trial for trial in trials if not trial.is_own]
    assert len(own) == 6
    assert len(foreign) >= 4
    assert sum(trial.right.any() for trial in own) >= 4
    assert not any(trial.right.any() for trial in foreign)
    again = list(TrialSource('generated', 77, None, FpnetConfig(), matcher()).trials(0))
    np.testing.assert_array_equal(again[0].evidence.figures, trials[0].evidence.figures)


@pytest.mark.real
@needs('.')
@pytest.mark.parametrize('kind', ['real', 'drawn', 'foreign'])
def test_real_maps_meet_their_own_plan_and_others(kind):
    source = TrialSource(kind, 77, DATA, FpnetConfig(), matcher())
    trials = [trial for index in range(6) for trial in source.trials(index)]
    own = [trial for trial in trials if trial.is_own]
    assert (len(own) == 0) == (kind == 'foreign')
    assert len(trials) - len(own) >= 9
    if own:
        assert sum(trial.right.any() for trial in own) >= 2
        assert all(np.isfinite(trial.evidence.figures).all() for trial in trials)


def test_looks_of_a_drive_see_more_each_time(monkeypatch):
    monkeypatch.setattr(scorer_drives, 'DRIVE_S', 8.0)
    trials = list(DriveSource(3, FpnetConfig(), matcher()).trials(0))
    own = [trial for trial in trials if trial.is_own]
    assert len(own) >= 2
    assert any(trial.right.any() for trial in own)
    assert not any(trial.right.any() for trial in trials if not trial.is_own)
    walls = [trial.evidence.context[1] for trial in own]  # log of the free space
    assert (np.diff(walls) > 0.0).all()


def test_the_benchmark_measures_what_is_packaged_and_draws_it(tmp_path):
    out, plot = tmp_path / 'report.json', tmp_path / 'reliability.png'
    arguments = ['bench', 'calibration', '--limit', '4', '--drives', '0', '--seed', '9']
    with pytest.raises(SystemExit) as ended:
        main([*arguments, '--json', str(out), '--plot', str(plot)])
    assert ended.value.code == 0
    report = json.loads(out.read_text(encoding='utf-8'))
    assert report['own_trials'] == 4
    assert report['wrong_claims'] == report['foreign_claims'] == 0
    assert report['right_best'] > 0.5
    assert report['kinds']['maps']['ece'] == report['ece'] < 0.3
    assert plot.read_bytes().startswith(b'\x89PNG')
