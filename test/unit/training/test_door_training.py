# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fitting what tells doors from lines inside of rooms."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.errors import FpnetError
from fpnet_core.io.weights import read_weights
from fpnet_core.segmentation.door_figures import LINE_FIGURES
from fpnet_core.segmentation.door_model import DOOR_SCHEMA, MAP_FIGURES, model_of
from fpnet_core.segmentation.joining import DividingLines, Pieces, join_pieces
from fpnet_core.segmentation.rooms import cut_parts
from fpnet_lab.sim.plans.sources import GeneratedPlans
from fpnet_lab.training.door_samples import (
    DoorAmounts,
    DoorSample,
    _drive,
    _generated,
    _samples,
    _tour,
    door_tasks,
    with_wide_openings,
)
from fpnet_lab.training.doors import (
    DoorTraining,
    fit_doors,
    folds,
    held_back_figures,
    lines_shown,
    room_f1,
    write_doors,
)

QUICK = DoorTraining(members=1, width=8, epochs=8, batch_size=64, rounds=2, folds=2)
WIDTH = LINE_FIGURES.index('width')


def made_up(rng, count=40, rooms=5):
    """Rooms of two pieces each in a row: openings of 2 m and more part nothing, doors do."""
    samples = []
    for number in range(count):
        pieces = 2 * rooms
        area = rng.uniform(4.0, 8.0, pieces + 1) * (np.arange(pieces + 1) > 0)
        moments = np.stack([area, *(np.zeros_like(area) for _ in range(2)), area, 0 * area, area])
        pairs = np.stack([np.arange(1, pieces), np.arange(2, pieces + 1)], axis=1)
        is_inside = pairs[:, 0] % 2 == 1
        width = np.where(is_inside, rng.uniform(2.0, 3.0, pieces - 1), rng.uniform(0.8, 1.2))
        figures = rng.normal(size=(pieces - 1, len(LINE_FIGURES) + len(MAP_FIGURES)))
        figures[:, WIDTH] = width
        overlap = np.zeros((pieces + 1, rooms + 1))
        overlap[np.arange(1, pieces + 1), (np.arange(1, pieces + 1) + 1) // 2] = area[1:]
        samples.append(
            DoorSample(
                f'building {number}',
                'made up',
                number < count // 4,
                Pieces(moments.T, np.ones(pieces + 1), np.zeros(pieces + 1)),
                DividingLines(pairs, width, figures),
                overlap,
            )
        )
    return samples


def test_what_was_learned_joins_other_buildings():
    rng = np.random.default_rng(2)
    model = fit_doors(made_up(rng), QUICK)
    scores = [room_f1(sample, model) for sample in made_up(rng, 10)]
    assert np.mean(scores) > 0.95
    held_back = held_back_figures(made_up(rng), QUICK)
    assert held_back['made up']['maps'] == 40.0
    assert held_back['made up']['f1'] > 0.85


def test_the_same_samples_give_the_same_weights():
    samples = made_up(np.random.default_rng(0), 8)
    one, other = (fit_doors(samples, replace(QUICK, epochs=2)) for _ in range(2))
    for name, value in one.tensors.items():
        np.testing.assert_array_equal(value, other.tensors[name])


def test_lines_are_judged_by_the_true_rooms_of_what_has_joined():
    (sample,) = made_up(np.random.default_rng(1), 1)
    shown = lines_shown(sample, np.arange(11))
    np.testing.assert_array_equal(shown.is_one, np.arange(9) % 2 == 0)
    target = np.array([0, 1, 1, 3, 3, 5, 5, 7, 7, 9, 9])
    assert not lines_shown(sample, target).is_one.any()
    half = sample.overlap.copy()
    half[3] = half[3].sum() / 2.0 * np.isin(np.arange(6), (2, 5))  # in two rooms, half and half
    assert len(lines_shown(replace(sample, overlap=half), np.arange(11)).is_one) == 7


def test_no_building_is_on_both_sides_of_a_fold():
    samples = made_up(np.random.default_rng(1), 12)
    left_out = folds(samples, 3)
    assert sum(len(fold) for fold in left_out) == len(set.union(*left_out)) == 12
    assert all(any(s.is_real and s.building in fold for s in samples) for fold in left_out)


def test_weights_come_back_as_they_were(tmp_path):
    samples = made_up(np.random.default_rng(1), 4)
    first, *_ = samples
    model = fit_doors(samples, replace(QUICK, epochs=1))
    write_doors(tmp_path / 'doors.safetensors', model, QUICK, {'figures': {}})
    read = model_of(read_weights(tmp_path / 'doors.safetensors', DOOR_SCHEMA))
    scorers = [m.probability_of_one_room for m in (model, read)]
    one, other = (join_pieces(first.pieces, first.lines, scorer) for scorer in scorers)
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize('make', [_generated, _tour])
def test_generated_maps_have_pieces_in_their_true_rooms(make):
    scene, truth = next(
        made for seed in range(5) if (made := make(np.random.default_rng(seed))) is not None
    )
    assert truth.shape == scene.free.shape
    assert truth.max() >= 6
    assert (truth[scene.free] > 0).mean() > 0.6
    assert cut_parts(scene).pieces.moments[:, 0].sum() > 20.0


def test_wide_openings_stay_between_their_rooms():
    rng = np.random.default_rng(5)
    plan = GeneratedPlans(10, 20).storey(3, 0, 0).plan
    wide = [with_wide_openings(plan, rng) for _ in range(12)]
    doors = [pair for w in wide for pair in zip(plan.doors, w.doors, strict=True)]
    changed = [(old, new) for old, new in doors if new is not old]
    assert changed
    for old, new in changed:
        assert old.rooms == new.rooms
        assert 1.4 <= new.width_m <= 3.8
        assert abs((new.ends - old.ends.mean(axis=0)) @ old.normal).max() < 1e-6


def test_missing_data_is_named(tmp_path):
    first = next(door_tasks(tmp_path, 0, DoorAmounts().scaled(0.001)))
    with pytest.raises(FpnetError, match=r'\.png is missing'):
        _samples(first)


def test_a_drive_is_a_submap_of_its_building():
    scene, truth = _drive(5004, np.random.default_rng(0))  # planar: a second
    assert scene.has_scans
    assert not scene.sees_lintels
    assert (truth[scene.free] > 0).mean() > 0.8
