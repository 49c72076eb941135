# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fitting what doubts readings, and its file."""

from dataclasses import replace
import json

import numpy as np
import pytest

from fpnet_core.drawings.pictures.doubts import ROOM_FIGURES, SHEET_FIGURES, model_of
from fpnet_core.errors import FpnetError
from fpnet_lab.training.doubts import (
    DoubtTraining,
    DoubtTrial,
    fit_doubts,
    held_out_figures,
    threshold,
    write_doubts,
)

SETTINGS = DoubtTraining(right_doubted=0.1)


def planted(count=60, seed=0):
    """Readings that are wrong where much was left outside, of rooms wrong where they are open."""
    rng = np.random.default_rng(seed)
    trials = []
    for number in range(count):
        is_wrong = number % 3 == 0
        rooms = rng.normal(size=(12, len(ROOM_FIGURES)))
        whole = rng.uniform(0.3, 0.7, len(SHEET_FIGURES) - 3)
        whole[SHEET_FIGURES.index('lost') - 3] = 0.9 if is_wrong else 0.0
        right = rooms[:, ROOM_FIGURES.index('open')] < 0.5
        f1 = 0.4 if is_wrong else 0.95
        trials.append(DoubtTrial('scan', number // 2, f1, rooms, right, whole))
    return trials


def test_what_was_planted_is_found_in_buildings_left_out(tmp_path):
    trials = planted()
    model, held_out = fit_doubts(trials, SETTINGS)
    figures = held_out_figures(trials, held_out, model.doubted_from)
    assert figures['auc'] > 0.95
    assert figures['rooms_auc'] > 0.85
    assert figures['wrong_doubted'] > 0.9
    assert figures['right_doubted'] == pytest.approx(0.1, abs=0.05)
    write_doubts(tmp_path / 'doubts.json', model, SETTINGS, {})
    again = model_of(json.loads((tmp_path / 'doubts.json').read_text()))
    for trial in trials[:5]:
        assert again.wrong(trial.evidence) == pytest.approx(model.wrong(trial.evidence), abs=1e-4)


def test_nothing_is_learned_from_right_readings_alone():
    right = [replace(trial, f1=1.0) for trial in planted()]
    with pytest.raises(FpnetError, match='right and wrong'):
        fit_doubts(right, SETTINGS)


def test_the_threshold_leaves_a_share_of_the_right_ones_above():
    assert threshold(np.linspace(0, 1, 101), np.zeros(101, np.bool_), 0.05) == pytest.approx(0.95)
