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
    OTHER,
    DoubtTraining,
    DoubtTrial,
    fit_doubts,
    held_out_figures,
    write_doubts,
)

SETTINGS = DoubtTraining(right_doubted=0.1)


def planted(count=60, seed=0):
    """
    Readings that are wrong where much was left outside, of rooms wrong where they are open.

    Pictures of other things have hardly anything that is surely what it was taken for.
    """
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
        if is_wrong:
            unsure = whole.copy()
            unsure[SHEET_FIGURES.index('certainty') - 3] = 0.1
            none = np.zeros(len(right), np.bool_)
            trials.append(DoubtTrial(OTHER, 1000 + number, 0.0, rooms, none, unsure))
    return trials


def test_what_was_planted_is_found_in_buildings_left_out(tmp_path):
    trials = planted()
    model, held_out = fit_doubts(trials, SETTINGS)
    figures = held_out_figures(trials, held_out, model)
    assert figures['auc'] > 0.95
    assert figures['rooms_auc'] > 0.85
    assert figures['wrong_doubted'] > 0.9
    assert figures['right_doubted'] == pytest.approx(0.1, abs=0.05)
    assert figures['others'] == 20
    assert figures['others_known'] > 0.9
    assert figures['buildings_taken_for_others'] < 0.04
    write_doubts(tmp_path / 'doubts.json', model, SETTINGS, {})
    again = model_of(json.loads((tmp_path / 'doubts.json').read_text()))
    for trial in trials[:5]:
        assert again.wrong(trial.evidence) == pytest.approx(model.wrong(trial.evidence), abs=1e-4)
        assert again.other(trial.evidence) == pytest.approx(model.other(trial.evidence), abs=1e-4)


def test_nothing_is_learned_from_right_readings_alone():
    right = [replace(trial, f1=1.0) for trial in planted()]
    with pytest.raises(FpnetError, match='right and wrong'):
        fit_doubts(right, SETTINGS)
    with pytest.raises(FpnetError, match='other images'):
        fit_doubts([trial for trial in planted() if trial.kind != OTHER], SETTINGS)
