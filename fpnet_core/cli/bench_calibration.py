# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench calibration``: may one believe the localizer's probabilities?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import chain
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet_core.cli import common

if TYPE_CHECKING:
    from fpnet_core.config import LocalizerConfig
    from fpnet_core.evaluation.calibration import Reliability, Trial
    from fpnet_core.evaluation.robot_pairs import RobotPair

_FIT_SEED = 7001  # of the generated pairs and drives that constants are fitted to
_CUTS = 3  # variations of each real pair in each band of kept free space


def command(
    limit: Annotated[int, typer.Option('--limit', min=2, help='Generated pairs.')] = 200,
    drives: Annotated[
        int, typer.Option('--drives', min=0, max=42, help='Generated drives, half a minute each.')
    ] = 14,
    seed: common.SeedOption = None,
    fit: Annotated[
        bool, typer.Option('--fit', help='First fit the constants, to others.')
    ] = False,
    data: Annotated[
        Path | None,
        typer.Option(
            '--data',
            metavar='DIR',
            help='Shared data: measure on the real pairs of its tune half, too.',
        ),
    ] = None,
    config: common.ConfigOption = None,
    plot: Annotated[
        Path | None, typer.Option('--plot', metavar='FILE', help='Reliability diagram.')
    ] = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Compare claimed probabilities with the truth, on the right and on wrong buildings' plans.

    With --fit the constants are first fitted to generated pairs and drives of another seed. What
    is then measured, real pairs included, is held back from the fit.

    Example: fpnet bench calibration --limit 300 --seed 9 --plot out/reliability.png

    Example: fpnet bench calibration --limit 60 --data ../shared/data --fit
    """
    tree = common.load(config)
    from fpnet_core.evaluation import calibration, drive_trials
    from fpnet_core.evaluation.robot_pairs import BANDS, read_robot_pairs
    from fpnet_core.matching.learned import LearnedMatcher

    matcher = LearnedMatcher(tree.matcher)
    real = read_robot_pairs(data, 'tune') if data is not None else ()
    report: dict[str, Any] = {'seed': seed or 0}

    def gather(label: str, seed: int, pairs: tuple[RobotPair, ...]) -> dict[str, list[Trial]]:
        total = limit + drives + len(pairs) * _CUTS * len(BANDS)
        with common.progress(label, total) as advance:
            return {
                'maps': calibration.generated_trials(seed, limit, tree, matcher, advance),
                'drives': drive_trials.drive_trials(seed, drives, tree, advance),
                'real': calibration.robot_trials(pairs, _CUTS, tree, matcher, advance),
            }

    if fit:
        fitted_to = gather('fitting', _FIT_SEED, ())
        trials = list(chain(*fitted_to.values()))
        report['fitted'] = calibration.fit_posterior(trials, tree.localizer)
        for name, value in report['fitted'].items():
            typer.echo(f'localizer.{name}: {value:.3g}')
        fitted = tree.localizer.model_copy(update=report['fitted'])
        tree = tree.model_copy(update={'localizer': fitted})
        report['fitted_to'] = _reported('fitted to ', fitted_to, tree.localizer)
    kinds = gather('measuring', seed or 0, real)
    report['kinds'] = _reported('', kinds, tree.localizer)
    everything = list(chain(*kinds.values()))
    result = calibration.reliability(everything, tree.localizer)
    _print('all', result)
    report |= {'trials': len(everything), **_plain(result)}
    if plot is not None:
        from fpnet_core.viz.calibration import plot_reliability

        plot_reliability(plot, result.claimed, result.true, result.count, result.ece)
    if json_path is not None:
        common.write_json(json_path, report)


def _reported(
    prefix: str, kinds: Mapping[str, Sequence[Trial]], config: LocalizerConfig
) -> dict[str, Any]:
    """Print how reliable each kind of trial is, and return it as JSON takes it."""
    from fpnet_core.evaluation.calibration import reliability

    plain = {}
    for name, trials in kinds.items():
        if trials:
            result = reliability(trials, config)
            _print(prefix + name, result)
            plain[name] = _plain(result)
    return plain


def _print(name: str, result: Reliability) -> None:
    typer.echo(
        f'{name}: expected calibration error {result.ece:.3f}; best placement right on '
        f'{result.right_best:.1%} of the right plans; {result.claims} claims, '
        f'{result.wrong_claims} wrong; on {result.foreign_trials} wrong plans: '
        f'{result.foreign_claims}'
    )


def _plain(result: Reliability) -> dict[str, Any]:
    """Return the figures as JSON takes them: lists, and None for empty bins."""
    plain = asdict(result)
    for name in ('claimed', 'true', 'count'):
        values = plain[name].tolist()
        plain[name] = [None if math.isnan(value) else value for value in values]
    return plain
