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
from fpnet_lab.training.door_samples import (
    DoorAmounts,
    DoorSample,
    _generated,
    _samples,
    _tour,
    door_tasks,
)
from fpnet_lab.training.doors import (
    DoorTraining,
    fit_doors,
    held_back_figures,
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


def test_missing_data_is_named(tmp_path):
    first = next(door_tasks(tmp_path, 0, DoorAmounts().scaled(0.001)))
    with pytest.raises(FpnetError, match=r'\.png is missing'):
        _samples(first)
