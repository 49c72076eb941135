# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fit of the contrast factor of wall evidence between storeys relative to places on one plan."""

from __future__ import annotations

import argparse

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from fpnet_core.config import FpnetConfig
from fpnet_core.scoring.scorer import STOREY_CONTRAST
from fpnet_core.types import LocalizerOutput
from fpnet_lab.evaluation.sites.site_drives import site_drive
from fpnet_lab.sim.drawn.storeys import Likeness

_LEAST = 1e-12  # numerical: smaller probabilities count as zero
_MOST = 5.0  # numerical: largest contrast of the search


def main() -> None:
    """Print the contrast that calibrates the probabilities of storeys."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--sites', type=int, default=12)
    parser.add_argument('--seed', type=int, default=4000)
    given = parser.parse_args()
    cv2.setNumThreads(1)
    gaps = [_gaps(number, given.seed) for number in range(given.sites)]
    gaps = [each for each in gaps if len(each)]

    def cost(contrast: float) -> float:
        return float(sum(np.logaddexp(0.0, -contrast * each).mean() for each in gaps))

    found = minimize_scalar(cost, bounds=(0.2, _MOST), method='bounded').x
    wrong = sum(int((each < 0.0).sum()) for each in gaps)
    print(f'{sum(map(len, gaps))} updates of {len(gaps)} sites, {wrong} with a wrong storey first')
    for contrast in (1.0, 1.5, 2.0, 3.0, found):
        likely = [float((contrast * each >= np.log(99.0)).mean()) for each in gaps]
        over = sum(int((contrast * each <= -np.log(99.0)).sum()) for each in gaps)
        print(
            f'contrast {contrast:.2f}: cost {cost(contrast):.3f}, correct storey above 99 % in '
            f'{np.mean(likely):.2f} of updates, a wrong one in {over}'
        )


def _gaps(number: int, seed: int) -> NDArray[np.float64]:
    """Return the correct storey's log odds at each update, without contrast."""
    run = site_drive(number, seed, FpnetConfig(), equal_every=0)
    true = next(s.name for s in run.storeys if s.likeness is Likeness.TRUE)
    gaps = [_gap(output, true) for output in run.replayed.outputs]
    return np.array([gap for gap in gaps if gap is not None]) / STOREY_CONTRAST


def _gap(output: LocalizerOutput, true: str) -> float | None:
    others = [p for name, p in output.storeys.items() if name != true]
    here, there = output.storeys.get(true, 0.0), max(others, default=0.0)
    if min(here, there) < _LEAST:  # one of them was not evaluated yet
        return None
    return float(np.log(here) - np.log(there))


if __name__ == '__main__':
    main()
