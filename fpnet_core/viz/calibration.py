# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reliability diagram: how often a claimed probability comes true."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_SIZE_INCHES, _DPI = (6.5, 6.0), 110


def plot_reliability(
    path: Path,
    claimed: NDArray[np.float64],
    true: NDArray[np.float64],
    count: NDArray[np.int64],
    ece: float,
) -> None:
    """
    Write the diagram to the image ``path``; its folder is created.

    ``claimed``, ``true`` and ``count`` are ``(B,)``: mean probability, share of right placements
    and number of trials of each bin, NaN in empty ones; ``ece`` is the calibration error.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE_INCHES, layout='constrained')
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(4, 1))
    seen = count > 0
    upper.plot([0, 1], [0, 1], color='0.7', linestyle='--', label='perfectly calibrated')
    upper.plot(claimed[seen], true[seen], marker='o', label='localizer')
    upper.set(
        ylabel='share of right placements',
        title=f'expected calibration error {ece:.3f}',
        xlim=(0, 1),
        ylim=(0, 1.02),
    )
    upper.legend(loc='lower right')
    middles = [(k + 0.5) / len(count) for k in range(len(count))]
    lower.bar(middles, count, width=0.9 / len(count), color='0.6')
    lower.set(xlabel='claimed probability of the best placement', ylabel='trials', yscale='log')
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=_DPI)
