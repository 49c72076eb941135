# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench calibration``: calibration of the localizer's probabilities."""

from __future__ import annotations

from dataclasses import asdict
from itertools import chain
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_lab.cli.options import Half
from fpnet_lab.cli.reports import finish

if TYPE_CHECKING:
    from fpnet_lab.metrics import Reliability
    from fpnet_lab.training.scorer_trials import Trial

_MEASURED_SEED = 5000
"""Numerical: added to the seed, so that trials differ from those of training."""


def command(
    limit: Annotated[int, typer.Option('--limit', min=1, help='Generated maps.')] = 100,
    drives: Annotated[
        int, typer.Option('--drives', min=0, max=42, help='Recordings, half a minute each.')
    ] = 10,
    real: Annotated[
        int, typer.Option('--real', min=0, help='Crops of real robot maps, with --data.')
    ] = 100,
    seed: common.SeedOption = None,
    data: Annotated[
        Path | None,
        typer.Option('--data', metavar='DIR', help='Shared data: also use real pairs.'),
    ] = None,
    half: Annotated[Half, typer.Option('--half', help='Split of the shared data.')] = Half.TUNE,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    plot: Annotated[
        Path | None, typer.Option('--plot', metavar='FILE', help='Reliability diagram.')
    ] = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Compare stated probabilities with the truth, on correct and on other buildings' plans.

    Generated maps and recordings have seeds that the scorer was not trained on; the real pairs
    have buildings that it was not trained on with --half report only.

    Example: fpnet bench calibration --limit 300 --seed 9 --plot out/reliability.png

    Example: fpnet bench calibration --data ../shared/data --half report
    """
    tree = common.load(config, settings)
    from fpnet_core.matching.learned import LearnedMatcher
    from fpnet_core.scoring import configured_model
    from fpnet_lab.training.scorer_drives import DriveSource
    from fpnet_lab.training.scorer_figures import reliability
    from fpnet_lab.training.scorer_trials import TrialSource

    matcher = LearnedMatcher(tree.matcher)
    measured_seed = _MEASURED_SEED + (seed or 0)
    sources: dict[str, tuple[Any, int]] = {
        'maps': (TrialSource('generated', measured_seed, None, tree, matcher), limit),
        'drives': (DriveSource(measured_seed, tree, matcher), drives),
    }
    if data is not None:
        pairs = TrialSource('real', measured_seed, data, tree, matcher, half.value)
        sources['real'] = (pairs, real)
    kinds: dict[str, list[Trial]] = {}
    with progress('measuring', sum(count for _, count in sources.values())) as advance:
        for name, (source, count) in sources.items():
            kinds[name] = []
            for index in range(count):
                kinds[name] += source.trials(index)
                advance(1.0)
    model = configured_model(tree.localizer)
    results = {
        name: reliability(trials, model, tree.localizer)
        for name, trials in kinds.items()
        if trials
    }
    everything = reliability(list(chain(*kinds.values())), model, tree.localizer)
    if plot is not None:
        from fpnet_lab.viz.calibration import plot_reliability

        plot_reliability(plot, {**results, 'all': everything})
    report = {'seed': seed or 0, 'half': half.value, **_plain(everything)}
    report['kinds'] = {
        name: {'maps': sources[name][1], **_plain(result)} for name, result in results.items()
    }
    finish('calibration', json_path, report)


def _plain(result: Reliability) -> dict[str, Any]:
    """Return the figures for JSON: lists, and None for empty bins."""
    plain = asdict(result)
    for name in ('claimed', 'true', 'count'):
        values = plain[name].tolist()
        plain[name] = [None if math.isnan(value) else value for value in values]
    return plain
