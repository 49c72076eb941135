# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trials from a real drive: what the localizer found, beside where the robot was."""

import numpy as np
import pytest

from fpnet_core.config import FpnetConfig
from fpnet_core.evaluation import drive_trials as module
from fpnet_core.evaluation.drive_trials import drive_trials


@pytest.fixture(scope='module')
def trials():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, 'DRIVE_S', 8.0)
        patch.setattr(module, 'WRONG_PLANS', 1)
        return drive_trials(3, 1, FpnetConfig())


def test_a_drive_gives_trials_of_its_own_and_of_another_plan(trials):
    own = [trial for trial in trials if not trial.is_foreign]
    foreign = [trial for trial in trials if trial.is_foreign]
    assert len(own) >= 2
    assert len(foreign) >= 1
    assert all(trial.truth is None for trial in foreign)
    assert any(trial.truth == 0 for trial in own)


def test_every_trial_has_seen_more_than_the_one_before(trials):
    for is_foreign in (False, True):
        walls = [trial.wall_length_m for trial in trials if trial.is_foreign is is_foreign]
        assert (np.diff(walls) > 0.0).all()
    assert all((np.diff(trial.scores) <= 0.0).all() for trial in trials)
