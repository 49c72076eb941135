# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reliability diagram: stated probability against observed frequency."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from fpnet.viz.pictures import DPI, saved_figure
from fpnet_lab.metrics import Reliability

_SIZE_INCHES = (6.5, 6.0)  # chosen


def plot_reliability(path: Path, results: Mapping[str, Reliability]) -> None:
    """
    Write the diagram to the image ``path`` and create its folder.

    ``results`` are by kind of trial, with ``all``; the bars show the trial counts of ``all``.
    """
    with saved_figure(path, _SIZE_INCHES, DPI) as figure:
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(4, 1))
        upper.plot([0, 1], [0, 1], color='0.7', linestyle='--', label='perfectly calibrated')
        for name, result in results.items():
            seen = result.count > 0
            upper.plot(
                result.claimed[seen],
                result.true[seen],
                marker='o',
                linewidth=2.0 if name == 'all' else 1.0,
                label=f'{name} (error {result.ece:.3f})',
            )
        upper.set(ylabel='share of right placements', xlim=(0, 1), ylim=(0, 1.02))
        upper.legend(loc='lower right')
        count = results['all'].count
        middles = [(k + 0.5) / len(count) for k in range(len(count))]
        lower.bar(middles, count, width=0.9 / len(count), color='0.6')
        lower.set(xlabel='stated probability of the best placement', ylabel='trials', yscale='log')
