# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench calibration`` fits to one seed and measures on another."""

import json

import numpy as np
import pytest

from fpnet_core.cli import main
from fpnet_core.evaluation import calibration
from fpnet_core.evaluation.calibration import Trial
from fpnet_core.matching import learned


@pytest.fixture
def seeds(monkeypatch):
    """Stand in for the trials; returns the seeds that were asked for."""
    asked = []

    def trials(seed, count, config, matcher, on_pair):
        asked.append(seed)
        right = Trial(np.array([0.9, 0.5]), 200.0, 0, False)
        foreign = Trial(np.array([0.5, 0.49]), 200.0, None, True)
        return [right, foreign] * count

    monkeypatch.setattr(calibration, 'generated_trials', trials)
    monkeypatch.setattr(learned, 'LearnedMatcher', lambda config: None)
    return asked


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main(['bench', 'calibration', *map(str, arguments)])
    assert ended.value.code == 0


def test_without_a_fit_the_constants_in_force_are_measured(seeds, tmp_path):
    out = tmp_path / 'report.json'
    run('--limit', 3, '--drives', 0, '--seed', 9, '--json', out)
    report = json.loads(out.read_text(encoding='utf-8'))
    assert seeds == [9]
    assert 'fitted' not in report
    assert (report['claims'], report['wrong_claims'], report['foreign_trials']) == (3, 0, 3)


def test_a_fit_is_measured_on_another_seed_and_drawn(seeds, tmp_path, monkeypatch):
    fitted = {'evidence_per_m': 0.001}  # nothing can be claimed with so little evidence
    monkeypatch.setattr(calibration, 'fit_posterior', lambda trials, start: fitted)
    out, plot = tmp_path / 'report.json', tmp_path / 'reliability.png'
    run('--limit', 2, '--drives', 0, '--fit', '--json', out, '--plot', plot)
    report = json.loads(out.read_text(encoding='utf-8'))
    assert len(set(seeds)) == 2
    assert report['fitted'] == fitted
    assert report['claims'] == 0
    assert plot.read_bytes().startswith(b'\x89PNG')
