# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench peers``: the localizer and other methods on the same recordings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_lab.cli import options
from fpnet_lab.cli.bench_localization import localized
from fpnet_lab.cli.reports import finish

if TYPE_CHECKING:
    from fpnet_core.config import FpnetConfig


def command(
    limit: Annotated[int, typer.Option('--limit', min=1, help='Drives.')] = 12,
    group: Annotated[
        list[str] | None,
        typer.Option(
            '--group', metavar='NAME', help='Group of recordings, e.g. logs (real); repeatable.'
        ),
    ] = None,
    maps: Annotated[
        int, typer.Option('--maps', min=0, help='Real robot maps on real drawings.')
    ] = 40,
    workers: options.WorkersOption = 1,
    data: options.RealDataOption = Path('../shared/data'),
    work: options.WorkOption = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Compare the localizer with other methods on the same recordings, maps and plans.

    Monte Carlo localization, correlative search, branch and bound, and the paper's matching with
    RANSAC use the same submaps, odometry and plans, and so do KISS-Matcher and MapClosures (extra
    peers), if installed. Each recording is also run on a plan of another building. The recordings
    are the first of fpnet bench localization. Methods that need no recording also place real robot
    maps, complete and cropped, on real drawings, as in fpnet bench matching --set robot.

    Example: fpnet bench peers --limit 12 --work out/peers --json out/peers.json

    Example: fpnet bench peers --group logs --maps 0
    """
    tree = common.load(config, settings, seed)
    from fpnet_lab.baselines.cloud_registration import CLOUD_METHODS, installed
    from fpnet_lab.evaluation.localization.cases import make_suite, select
    from fpnet_lab.evaluation.localization.peers import peer_figures
    from fpnet_lab.evaluation.localization.runs import Job

    clouds = installed()
    for name in sorted(set(CLOUD_METHODS) - set(clouds)):
        common.say(f"{name} is skipped: pip install 'fpnet_ros[peers]'", json_path)
    cases = select(make_suite(tree.seed), group, limit)
    jobs = [Job(case, tree, tree.seed, data, clouds=clouds) for case in cases]
    records, skipped = localized(jobs, work, workers, json_path)
    report: dict[str, Any] = {'methods': peer_figures(records), 'skipped': skipped}
    if maps and (data / 'bormann').is_dir():
        report['maps'] = _on_maps(data, maps, tree, clouds)
    elif maps:
        common.say(
            f'no real maps: {data}/bormann is missing; give their folder with --data', json_path
        )
    finish('peers', json_path, report)


def _on_maps(data: Path, limit: int, tree: FpnetConfig, clouds: tuple[str, ...]) -> dict[str, Any]:
    """Return the figures of each method on real robot maps of the test split."""
    from fpnet_core.matching.learned import LearnedMatcher
    from fpnet_lab.evaluation.matching_robot import bench_robot_maps, robot_cases

    cases = robot_cases(data, 'report', limit, foreign=1)
    rasters = ('branch_and_bound', 'correlative', *clouds)
    own = {'fpnet': LearnedMatcher(tree.matcher)}
    with progress('placing maps', len(cases)) as advance:
        found: dict[str, Any] = bench_robot_maps(cases, own, tree, rasters, advance)['methods']
    return found
