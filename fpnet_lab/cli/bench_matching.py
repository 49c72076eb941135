# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench matching``: every region matcher on the same pairs of graphs."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_core.errors import FpnetError, WeightsError
from fpnet_lab.cli.reports import show, write_report
from fpnet_lab.scores import Column, Table, Units, columns, named

if TYPE_CHECKING:
    from fpnet_core.config import FpnetConfig, MatcherConfig
    from fpnet_core.matching import RegionMatcher
    from fpnet_lab.sim.pairs.pair import MatchingPair


class PairSet(StrEnum):
    """Source of the pairs."""

    SYNTHETIC = 'synthetic'
    REAL = 'real'
    CHALLENGING = 'challenging'
    TOURS = 'tours'
    ROBOT = 'robot'


_METHODS = (  # numerical: digits
    Column('method', 'name'),
    *columns(Units.FINE_SHARE, {'ts': 'TS', 'ms': 'MS', 'auc10': 'AUC@10'}),
    *columns(Units.FINE_SHARE, {'match_precision': 'precision', 'match_recall': 'recall'}),
    Column('1 m 10 deg', 'recall_1m_10deg', Units.FINE_SHARE),
    Column('a pair', 'ms_per_pair', Units.MS.to(1)),
)
_CLAIMS = {
    'right': 'right',
    'claimed_right': 'right claims',
    'wrong_and_claimed': 'wrong claims',
    'foreign_random_claimed': 'elsewhere',
    'foreign_same_architect_claimed': 'same architect',
}
_BANDS = (Column('kept', 'name'), *columns(Units.FINE_SHARE, _CLAIMS), Column('pairs', 'pairs'))

DataOption = Annotated[
    Path | None,
    typer.Option(
        '--data',
        metavar='DIR',
        help='Stored pairs of the set, or the folder of real maps for robot; default: generate.',
    ),
]
PlansOption = Annotated[
    Path | None,
    typer.Option('--plans', metavar='DIR', help='Real floorplans, for the set real.'),
]
MethodsOption = Annotated[
    str | None,
    typer.Option('--methods', metavar='A,B', help='Only these methods; default: all.'),
]


def command(
    pair_set: Annotated[PairSet, typer.Option('--set', help='Kind of pairs.')] = PairSet.SYNTHETIC,
    data: DataOption = None,
    plans: PlansOption = None,
    split: Annotated[
        str, typer.Option('--split', metavar='tune|report', help='Split of the real buildings.')
    ] = 'report',
    limit: Annotated[
        int | None, typer.Option('--limit', min=1, help='Largest number of pairs.')
    ] = None,
    methods: MethodsOption = None,
    foreign: Annotated[
        int,
        typer.Option(
            '--foreign', min=0, help="Other buildings' plans to match each map with, for robot."
        ),
    ] = 3,
    config: common.ConfigOption = None,
    weights: Annotated[
        Path | None, typer.Option('--weights', help='Checkpoint of fpnet; default: packaged.')
    ] = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Match every pair with every method; score the matches and the transforms from them.

    Methods without packaged weights are skipped with a message. With --set robot the JSON also
    has, by method and kept share of the robot map (bands), the shares of right, accepted, wrongly
    accepted results, and of those accepted on plans of other buildings. The method correlative
    accepts every result and is not run on other buildings: null.

    Example: fpnet bench matching --set synthetic --limit 100 --json out/bench.json

    Example: fpnet bench matching --set robot --data ../shared/data --methods fpnet --split tune
    """
    tree = common.load(config, [f'matcher.weights={weights}'] if weights else None)
    if pair_set is PairSet.ROBOT:
        report = _robot(data, split, limit, methods, foreign, tree)
    else:
        report = _graphs(_pairs(pair_set, data, plans, split, limit), _names(methods), tree)
    report['set'] = pair_set.value
    show(Table.of(_METHODS, named(report['methods'])), json_path)
    if pair_set is PairSet.ROBOT:
        for name, figures in report['methods'].items():
            show(Table.of(_BANDS, named(figures['bands'])), json_path, name)
    write_report(json_path, report)


def _graphs(pairs: list[MatchingPair], names: list[str], tree: FpnetConfig) -> dict[str, Any]:
    from fpnet_lab.evaluation.matching import predict, score

    with progress('matching', len(pairs)) as advance:
        predictions = predict(pairs, matchers(tree.matcher, names), advance)
    return {'methods': score(pairs, predictions), 'pairs': len(pairs)}


def _pairs(
    pair_set: PairSet, data: Path | None, plans: Path | None, split: str, limit: int | None
) -> list[MatchingPair]:
    from fpnet_lab.evaluation.pair_sets import DEFAULT_PAIRS, generated_pairs, stored_pairs

    if data is not None:
        return stored_pairs(common.check_input(data), limit)
    made = []
    with progress('generating pairs', limit or DEFAULT_PAIRS) as advance:
        for pair in generated_pairs(pair_set.value, plans, split, limit):
            made.append(pair)
            advance(1.0)
    return made


def _robot(
    data: Path | None,
    split: str,
    limit: int | None,
    methods: str | None,
    foreign: int,
    tree: FpnetConfig,
) -> dict[str, Any]:
    from fpnet_lab.evaluation.matching_robot import bench_robot_maps, robot_cases
    from fpnet_lab.evaluation.raster_methods import CLAIMS_ALL, RASTER_METHODS

    if data is None:
        raise FpnetError('the set robot needs the real maps; give --data FOLDER')
    cases = robot_cases(common.check_input(data), split, limit, foreign)
    names = [*_names(methods), *([CLAIMS_ALL] if methods is None else [])]
    rasters = [name for name in names if name in RASTER_METHODS]
    made = matchers(tree.matcher, [name for name in names if name not in RASTER_METHODS])
    with progress('matching', len(cases)) as advance:
        return bench_robot_maps(cases, made, tree, rasters, advance)


def _names(methods: str | None) -> list[str]:
    from fpnet_lab.baselines import MATCHERS
    from fpnet_lab.evaluation.raster_methods import RASTER_METHODS

    names = list(MATCHERS) if methods is None else methods.split(',')
    known = (*MATCHERS, *RASTER_METHODS)
    for name in names:
        if name not in known:
            raise FpnetError(f'no method {name!r}; expected some of {", ".join(known)}')
    return names


def matchers(config: MatcherConfig, names: list[str]) -> dict[str, RegionMatcher]:
    """Return the matchers of ``names``; skip those without packaged weights with a message."""
    from fpnet_lab.baselines import MATCHERS

    made: dict[str, RegionMatcher] = {}
    for name in names:
        try:
            made[name] = MATCHERS[name](config)
        except WeightsError as error:
            if name == 'fpnet':
                raise
            typer.echo(f'{name} is skipped: {error}', err=True)
    return made
