# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fit of the weights of differences between drawing and observation, on generated buildings."""

from __future__ import annotations

import argparse

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from fpnet_core.config import FpnetConfig
from fpnet_core.differences import DifferenceKind
from fpnet_core.differences.finding import MISSING_FIGURES, WALL_FIGURES
from fpnet_lab.evaluation.sites.differences import LEAST_M, Labelled, difference_cases, labelled

_PRIOR_SIGMA = 3.0
"""Chosen: standard deviation of the weights' prior."""


def main() -> None:
    """Print the weights and their classification performance."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--drives', type=int, default=48)
    parser.add_argument('--seed', type=int, default=5000)
    given = parser.parse_args()
    cv2.setNumThreads(1)
    config, found, drives = FpnetConfig(), [], []
    for seed in range(given.seed, given.seed + given.drives):
        for case in difference_cases(seed, config):
            pieces = labelled(case, case.found())
            found += pieces
            drives += [seed] * len(pieces)
    is_missing = np.array([each.piece.kind is DifferenceKind.MISSING for each in found])
    for names, rows in ((WALL_FIGURES, ~is_missing), (MISSING_FIGURES, is_missing)):
        chosen = [found[row] for row in np.flatnonzero(rows)]
        _report(names, chosen, np.array(drives)[rows])


def _report(names: tuple[str, ...], found: list[Labelled], drives: NDArray[np.int64]) -> None:
    """Print the weights of all recordings, and leave-one-out precision and recall."""
    figures = np.array([each.piece.figures for each in found])
    is_right = np.array([each.is_wall for each in found])
    weights = _fit(figures, is_right)
    correct = int(((figures @ weights > 0.0) == is_right).sum())
    print(f'{names}: {tuple(np.round(weights, 1).tolist())}')
    print(f'  {len(found)} pieces, {is_right.sum()} right; classified correctly: {correct}')
    claimed = np.zeros(len(found), np.bool_)
    for drive in np.unique(drives):
        others = drives != drive
        claimed[~others] = figures[~others] @ _fit(figures[others], is_right[others]) > 0.0
    is_long = np.array([each.piece.length_m >= LEAST_M for each in found])
    met = float((claimed & is_right & is_long).sum())
    precision, recall = (met / max((mask & is_long).sum(), 1) for mask in (claimed, is_right))
    print(f'  leave-one-out, 1 m or longer: precision {precision:.0%}, recall {recall:.0%}')


def _fit(figures: NDArray[np.float64], is_right: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the weights (K,) of features ``figures (N, K)`` for labels ``is_right (N,)``."""

    def cost(weights: NDArray[np.float64]) -> float:
        logits = np.where(is_right, 1.0, -1.0) * (figures @ weights)
        prior = (weights[1:] / _PRIOR_SIGMA) ** 2
        return float(np.logaddexp(0.0, -logits).sum() + 0.5 * prior.sum())

    return np.asarray(minimize(cost, np.zeros(figures.shape[1])).x)


if __name__ == '__main__':
    main()
