# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fitting what tells the scale of maps."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.errors import FpnetError
from fpnet_core.io.weights import read_weights
from fpnet_core.segmentation.scale_figures import FIGURES, ScaleFigures
from fpnet_core.segmentation.scale_model import SCALE_SCHEMA, model_of, quantiles
from fpnet_lab.metrics.intervals import interval_figures
from fpnet_lab.training.scale import ScaleTraining, fit_scale, write_scale
from fpnet_lab.training.scale_samples import ScaleAmounts, ScaleSamples, scale_tasks

# All made-up buildings are alike: the more some weigh, the fewer there are to learn from.
QUICK = ScaleTraining(members=2, epochs=30, noise=0.05, tail_share=(0.0, 0.0), real_weight=16.0)
DOOR_M, SPREAD = 0.93, 0.05


def made_up(rng, count=300):
    """Buildings whose doors are 0.93 m wide up to 5 per cent; nothing else says anything."""
    truth = rng.normal(0.0, 0.3, count)
    reference = rng.normal(0.3, 0.2, count)
    values = rng.normal(0.0, 0.3, (count, len(FIGURES)))
    door = np.log(DOOR_M) + rng.normal(0.0, SPREAD, count)
    for name in ('door_mode', 'door_25', 'door_50'):
        values[:, FIGURES.index(name)] = door - truth - reference
    values[rng.random(values.shape) < 0.05] = np.nan
    return ScaleSamples(
        values,
        reference,
        truth,
        np.where(np.arange(count) % 2 == 0, 'plan', 'map'),
        np.array([f'building {k % 60}' for k in range(count)]),
        np.arange(count) % 60 < 6,
        np.ones(count, dtype=np.bool_),
    )


def estimates(model, samples):
    return np.array(
        [
            quantiles(
                model.posterior(
                    ScaleFigures(samples.values[k], samples.reference[k]), samples.side[k]
                ),
                (0.05, 0.5, 0.95),
            )
            - samples.truth[k]
            for k in range(len(samples))
        ]
    )


def test_what_was_learned_holds_on_other_buildings():
    rng = np.random.default_rng(3)
    model = fit_scale(made_up(rng, 1200), QUICK)
    figures = interval_figures(estimates(model, made_up(rng, 200)))
    assert figures['within_10'] > 0.8
    assert 0.8 < figures['held'] < 1.0


def test_the_same_samples_give_the_same_weights():
    samples = made_up(np.random.default_rng(0), 60)
    one, other = (fit_scale(samples, replace(QUICK, epochs=2)) for _ in range(2))
    for name, value in one.tensors.items():
        np.testing.assert_array_equal(value, other.tensors[name])


def test_weights_are_written_with_their_manifest(tmp_path):
    settings = replace(QUICK, epochs=1)
    model = fit_scale(made_up(np.random.default_rng(0), 60), settings)
    write_scale(tmp_path / 'scale.safetensors', model, settings, {'figures': {}, 'data': {}})
    read = model_of(read_weights(tmp_path / 'scale.safetensors', SCALE_SCHEMA))
    for name, value in model.tensors.items():
        np.testing.assert_array_equal(value, read.tensors[name])
    assert read.tensors.keys() == model.tensors.keys()


def test_intervals_are_counted():
    errors = np.log([[0.95, 1.0, 1.05], [0.99, 1.2, 1.3], [1.05, 1.12, 1.2], [0.5, 1.05, 2.0]])
    figures = interval_figures(errors)
    assert figures['within_10'] == 0.5
    assert figures['held'] == 0.75
    assert (figures['sure'], figures['sure_wrong']) == (0.5, 0.25)


def test_missing_data_is_named(tmp_path):
    with pytest.raises(FpnetError, match='is missing'):
        list(scale_tasks(tmp_path, 0, ScaleAmounts(), None))
