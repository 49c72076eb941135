# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a run was worth, and whether its covariances hold."""

import numpy as np
import pytest

from fpnet.accuracy import GATE_95, normalised_errors, summarize_run
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.trajectory import PlanarTrajectory

COUNT = 4000
STAMPS = np.arange(COUNT, dtype=np.int64) * 100_000_000
# A drawing at half its size along one axis, turned: errors are in its own metres.
A_PLAN_TRUTH = Affine2D(
    np.diag([0.5, 1.0]) @ SE2.from_xy_yaw(0.0, 0.0, 0.7).linear, np.array([3.0, -2.0])
)


def drawn(seed=2):
    """Return truth, published poses and the covariances that their errors were drawn from."""
    rng = np.random.default_rng(seed)
    truth = PlanarTrajectory(
        STAMPS, rng.uniform(-20.0, 20.0, (COUNT, 2)), rng.uniform(-3.1, 3.1, COUNT)
    )
    root = np.tril(rng.normal(size=(COUNT, 3, 3))) * [[0.1], [0.2], [0.02]]
    cov = root @ root.transpose(0, 2, 1) + 1e-4 * np.eye(3)
    error = np.einsum('nij,nj->ni', np.linalg.cholesky(cov), rng.normal(size=(COUNT, 3)))
    on_plan = truth.mapped(A_PLAN_TRUTH)
    published = PlanarTrajectory(STAMPS, on_plan.xy + error[:, :2], on_plan.yaw + error[:, 2])
    return truth, published, cov


def test_errors_drawn_from_their_covariances_are_normal():
    truth, published, cov = drawn()
    nees = normalised_errors(published, cov, truth, A_PLAN_TRUTH)
    assert len(nees) == COUNT
    assert nees.mean() == pytest.approx(3.0, abs=0.15)
    assert (nees <= GATE_95).mean() == pytest.approx(0.95, abs=0.01)
    summary = summarize_run(published, truth, np.zeros(1), truth, A_PLAN_TRUTH, cov)
    assert summary.nees_mean == pytest.approx(nees.mean())
    assert summary.sigma_position_m_median == pytest.approx(
        np.median(np.sqrt(cov[:, 0, 0] + cov[:, 1, 1]))
    )


def test_wrong_poses_are_counted_apart():
    truth, published, cov = drawn()
    far = published.xy.copy()
    far[:10] += 8.0
    astray = PlanarTrajectory(STAMPS, far, published.yaw)
    assert len(normalised_errors(astray, cov, truth, A_PLAN_TRUTH)) == COUNT - 10
    assert summarize_run(astray, truth, np.zeros(1), truth, A_PLAN_TRUTH, cov).wrong_poses == 10


def test_without_poses_truth_or_covariances_nothing_is_said():
    truth, published, cov = drawn()
    none = PlanarTrajectory(STAMPS[:0], np.zeros((0, 2)), np.zeros(0))
    assert len(normalised_errors(none, cov[:0], truth, A_PLAN_TRUTH)) == 0
    assert summarize_run(published, truth, np.zeros(1), truth, A_PLAN_TRUTH).nees_mean is None
    unknown = summarize_run(published, truth, np.zeros(1), covariances=cov)
    assert unknown.nees_mean is None
    assert unknown.sigma_yaw_deg_median > 0.0
