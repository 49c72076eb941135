# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fit what weighs differences between a drawing and what was seen, on generated buildings."""

from __future__ import annotations

import argparse

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from fpnet_core.config import FpnetConfig
from fpnet_core.differences import DifferenceKind
from fpnet_core.differences.finding import MISSING_FIGURES, WALL_FIGURES
from fpnet_lab.evaluation.differences import Labelled, difference_cases, labelled

_PRIOR_SIGMA = 3.0
"""Chosen: standard deviation of the weights before looking."""


def main() -> None:
    """Print the weights and how well they tell."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--drives', type=int, default=48)
    parser.add_argument('--seed', type=int, default=5000)
    given = parser.parse_args()
    cv2.setNumThreads(1)
    config, found = FpnetConfig(), []
    for seed in range(given.seed, given.seed + given.drives):
        for case in difference_cases(seed, config):
            found += labelled(case, case.found())
    is_missing = [each.piece.kind is DifferenceKind.MISSING for each in found]
    for names, wanted in ((WALL_FIGURES, False), (MISSING_FIGURES, True)):
        _fit(names, [f for f, m in zip(found, is_missing, strict=True) if m is wanted])


def _fit(names: tuple[str, ...], found: list[Labelled]) -> None:
    figures = np.array([each.piece.figures for each in found])
    is_right = np.array([each.is_wall for each in found])

    def cost(weights: NDArray[np.float64]) -> float:
        logits = np.where(is_right, 1.0, -1.0) * (figures @ weights)
        prior = (weights[1:] / _PRIOR_SIGMA) ** 2
        return float(np.logaddexp(0.0, -logits).sum() + 0.5 * prior.sum())

    weights = minimize(cost, np.zeros(len(names))).x
    told = int(((figures @ weights > 0.0) == is_right).sum())
    print(f'{names}: {tuple(np.round(weights, 1).tolist())}')
    print(f'  {len(found)} pieces, {is_right.sum()} right; told right {told}')


if __name__ == '__main__':
    main()
