# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How far a pose may be off: where the figures come from, and what follows from them."""

import json

import numpy as np
import pytest

from fpnet_core.errors import WeightsError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.pose import map_evidence
from fpnet_core.pose.uncertainty import (
    FIGURES,
    Misfit,
    UncertaintyModel,
    heading_residual_of,
    packaged_uncertainty,
    wall_information,
)
from fpnet_core.pose_covariance import Growth, PoseFeatures, carried
from fpnet_core.types import FREE, OCCUPIED, GridMap

CELL_M = 0.05
LENGTH_M, WIDTH_M = 30.0, 2.0
HERE = Affine2D(np.eye(2), np.zeros(2))
MIDDLE = np.array([LENGTH_M / 2, WIDTH_M / 2 + 1.0])
GOOD = Misfit(0.1, 0.1, 0.01)


def corridor(end_m=None):
    """Return the evidence of a bare corridor along x, closed at ``end_m``, and returns on it."""
    cells = np.full((round((WIDTH_M + 2.0) / CELL_M), round(LENGTH_M / CELL_M)), FREE, np.int8)
    low, high = round(1.0 / CELL_M), round((1.0 + WIDTH_M) / CELL_M)
    cells[[low, high]] = OCCUPIED
    x = np.arange(MIDDLE[0] - 4.0, MIDDLE[0] + 4.0, 0.1)
    seen = [np.column_stack([x, np.full(len(x), (row + 0.5) * CELL_M)]) for row in (low, high)]
    if end_m is not None:
        column = round(end_m / CELL_M)
        cells[low:high, column] = OCCUPIED
        y = np.arange(low, high, 2) * CELL_M
        seen.append(np.column_stack([np.full(len(y), (column + 0.5) * CELL_M), y]))
    return map_evidence(GridMap(cells, CELL_M)), np.concatenate(seen)


def spread_on(plan, seen, A=HERE, robot=MIDDLE, misfit=GOOD):
    features = PoseFeatures(wall_information(plan, seen, A, robot), misfit.figures)
    return packaged_uncertainty().covariance(features, robot, 0)


def test_the_covariance_is_longer_along_a_bare_corridor_than_across_it():
    cov = spread_on(*corridor()).cov
    assert cov[0, 0] > 3.0 * cov[1, 1]
    closed = spread_on(*corridor(end_m=MIDDLE[0] + 3.0)).cov
    assert closed[0, 0] < 0.7 * cov[0, 0]
    np.testing.assert_allclose(closed[1, 1], cov[1, 1], rtol=0.1)


def test_without_any_return_it_is_as_wide_as_it_can_be():
    plan, seen = corridor()
    cov = spread_on(plan, np.zeros((0, 2))).cov
    assert (np.diag(cov)[:2] >= np.diag(spread_on(plan, seen).cov)[:2]).all()
    np.testing.assert_allclose(cov[0, 0], cov[1, 1], rtol=1e-9)


@pytest.mark.parametrize('worse', [Misfit(0.4, 0.1, 0.01), Misfit(0.1, 0.3, 0.01)])
def test_what_fits_worse_is_known_worse(worse):
    plan, seen = corridor()
    cov = spread_on(plan, seen).cov
    assert np.linalg.det(spread_on(plan, seen, misfit=worse).cov) > 1.2 * np.linalg.det(cov)


def test_unrest_is_the_turn_of_what_was_seen_last_and_wears_off():
    plan, seen = corridor()
    turn = SE2.from_xy_yaw(0.0, 0.0, 0.02)
    turned = turn.apply(seen - MIDDLE) + MIDDLE
    found = heading_residual_of(plan, turned, HERE, MIDDLE)
    assert found == pytest.approx(0.02, rel=0.3)
    assert heading_residual_of(plan, seen, HERE, MIDDLE) < 0.003
    later = [
        heading_residual_of(plan, seen, HERE, MIDDLE, (found, age_s))
        for age_s in (1.0, 10.0, 100.0)
    ]
    assert found > later[0] > later[1] > later[2]
    assert heading_residual_of(plan, np.zeros((0, 2)), HERE, MIDDLE) == 0.0


def test_it_turns_with_the_map():
    plan, seen = corridor()
    turn = SE2.from_xy_yaw(3.0, -7.0, 0.9)
    grid = GridMap(np.where(plan.is_free, FREE, OCCUPIED).astype(np.int8), CELL_M, turn)
    cov, turned = spread_on(plan, seen).cov, spread_on(map_evidence(grid), seen, turn).cov
    R = np.eye(3)
    R[:2, :2] = turn.linear
    np.testing.assert_allclose(turned, R @ cov @ R.T, atol=0.03 * np.trace(cov))
    assert abs(turned[0, 1]) > 0.2 * turned[0, 0]


def test_a_covariance_is_positive_definite_and_grows_after_its_tick():
    rng = np.random.default_rng(4)
    model = packaged_uncertainty()
    for _ in range(50):
        root = rng.normal(size=(3, 3)) * rng.choice([0.0, 1.0, 30.0])
        figures = rng.normal(-3.0, 3.0, len(FIGURES))
        covariance = model.covariance(
            PoseFeatures(root @ root.T, figures), rng.normal(size=2), 10**9
        )
        A = Affine2D(np.diag([1.1, 0.9]), np.zeros(2))
        before = 0.0
        for seconds in (0, 1, 2, 10):
            cov = covariance.at(A, covariance.xy_odom, (1 + seconds) * 10**9)
            assert np.linalg.eigvalsh(cov).min() > 0.0
            assert np.linalg.det(cov) > before
            before = np.linalg.det(cov)
        stood = covariance.at(A, covariance.xy_odom, 2 * 10**9)
        driven = covariance.at(A, covariance.xy_odom + np.array([3.0, 0.0]), 2 * 10**9)
        assert np.trace(driven) > np.trace(stood)


def test_an_error_in_heading_moves_who_has_driven_on():
    """As sampled: the lever turns, and its share of position and heading go together."""
    growth = Growth(0.0, 0.0, 0.0, 0.0)
    cov, away = np.diag([0.01, 0.02, 0.03**2]), np.array([2.0, 1.0])
    draws = np.random.default_rng(1).multivariate_normal(np.zeros(3), cov, 100_000)
    moved = draws.copy()
    moved[:, :2] += draws[:, 2:] * [-away[1], away[0]]
    np.testing.assert_allclose(
        carried(cov, away, np.array(3.0), growth), np.cov(moved.T), atol=3e-4
    )


def test_a_model_of_other_figures_is_refused():
    stored = {'figures': ['bend'], 'mean': [], 'std': [], 'position': [], 'yaw': []}
    with pytest.raises(WeightsError, match='train covariance'):
        UncertaintyModel.from_json(json.loads(json.dumps(stored)))
