# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fitting how far poses may be off to errors whose spread is known."""

from dataclasses import fields, replace
import json
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from fpnet_core.pose.uncertainty import FIGURES, UncertaintyModel, packaged_uncertainty
from fpnet_core.pose_covariance import Growth
from fpnet_lab.kept import make_once
from fpnet_lab.training.covariance import (
    CovarianceTraining,
    consistency,
    covariances_of,
    fit_covariance,
    held_back_errors,
    normalised_errors_of,
    stored,
)
from fpnet_lab.training.covariance_drives import Samples

PLANTED = UncertaintyModel(
    mean=np.zeros(3),
    std=np.ones(3),
    position=np.array([-4.0, 0.6, 0.0, 0.0]),
    yaw=np.array([-7.5, 0.0, 0.0, 0.8]),
    growth=Growth(0.03, 0.01, 0.004, 0.003),
)


def planted(seed=0, count=4000, buildings=10):
    """Return samples whose errors are drawn from the planted model."""
    rng = np.random.default_rng(seed)
    faced = rng.uniform(5.0, 300.0, (count, 2))
    information = np.zeros((count, 3, 3))
    information[:, 0, 0], information[:, 1, 1], information[:, 2, 2] = *faced.T, 1e3
    building = np.arange(count) * buildings // count
    empty = np.zeros((count, 3))
    samples = Samples(
        rng.normal(size=(count, 3)), information, rng.normal(0.0, 1.0, (count, 2)),
        rng.uniform(0.0, 2.0, count), empty, 2 * building + np.arange(count) % 2, building,
    )  # fmt: skip
    root = np.linalg.cholesky(covariances_of(PLANTED, samples))
    error = np.einsum('nij,nj->ni', root, rng.normal(size=(count, 3)))
    columns = {each.name: getattr(samples, each.name) for each in fields(Samples)}
    return Samples(**{**columns, 'error': error})


@pytest.fixture(scope='module')
def samples():
    return planted()


@pytest.fixture(scope='module')
def fitted(samples):
    return fit_covariance(samples, CovarianceTraining(ridge=1e-4))


def test_a_fit_finds_what_was_planted(samples, fitted):
    ratio = np.diagonal(
        covariances_of(fitted, samples) / covariances_of(PLANTED, samples), axis1=1, axis2=2
    )
    assert np.exp(np.abs(np.log(ratio)).mean(axis=0)) == pytest.approx([1.0] * 3, abs=0.15)
    nees = normalised_errors_of(fitted, planted(seed=1))
    held = consistency(nees, samples.run)
    assert held['nees_mean'] == pytest.approx(3.0, abs=0.2)
    assert held['inside_95'] == pytest.approx(0.95, abs=0.01)


def test_buildings_that_are_left_out_tell_whether_a_fit_holds(samples):
    config = CovarianceTraining(folds=2, every=8)
    done = []
    nees = held_back_errors(samples, config, done.append)
    assert len(done) == 2
    held = consistency(nees, samples.run)
    assert held['nees_mean'] == pytest.approx(3.0, abs=0.3)
    assert held['runs'] == 20
    assert held['nees_worst_run'] >= held['nees_mean']


def test_a_stored_model_is_read_again(fitted, samples):
    read = UncertaintyModel.from_json(json.loads(json.dumps(stored(fitted, {'data': {}}))))
    np.testing.assert_allclose(
        covariances_of(read, samples), covariances_of(fitted, samples), rtol=2e-3, atol=1e-9
    )


def test_the_command_fits_to_the_drives_that_it_has(tmp_path: Path, samples):
    from fpnet_lab.cli.train_covariance import command

    tasks = {
        name: samples.where(samples.building == building)
        for building, name in enumerate(('3-000', '3-001', '3-002', '4-000'))
    }
    make_once(tmp_path / 'drives', Samples, tasks, replace, columns=FIGURES)
    app = typer.Typer()
    app.command()(command)
    said = ['--out', str(tmp_path), '--drives', '3', '--measured', '1', '--seed', '3']
    result = CliRunner().invoke(app, said)
    assert result.exit_code == 0, result.output
    assert 'left_out' in result.output
    written = json.loads((tmp_path / 'covariance.json').read_text())
    assert written['held']['other_seed']['runs'] == 2
    assert len(UncertaintyModel.from_json(written).mean) == 3


def test_what_is_shipped_was_fitted_and_says_how():
    model = packaged_uncertainty()
    assert len(model.mean) == len(FIGURES)
    # What bends more and lies off more is known worse.
    assert (model.position[1:3] > 0.0).all()
    assert model.yaw[3] > 0.0
