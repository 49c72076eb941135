# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Localization of the real Intel and Freiburg-079 laser logs on their drawn floorplans.

Run: python benchmarks/real_logs.py ../shared/data/radish [--set KEY=VALUE ...] [--json OUT]; then
fpnet bench figures real_logs=OUT

Both buildings are in the test split. The drawings' scale is off by up to 20 %, x relative to y by
up to 11 %. The configuration is the default one, except for an update every 10 s and the prior of
the scale: default, off by up to a quarter, or unknown.
Errors are in the log's metres relative to a fitted, not surveyed, placement. ``best_over_time``
lists the best placement of every update, accepted or not, as ``[error m, probability,
agreement]``.
"""

from itertools import product
from pathlib import Path

import numpy as np

from fpnet.accuracy import summarize_run
from fpnet.cli.common import parse_settings
from fpnet.recordings.opening import open_scans
from fpnet_core.config import load_config
from fpnet_core.localizer import create_localizer, replay
from fpnet_core.odometry import KissOdometry
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.evaluation.fitted_truth import read_fitted_truth
from fpnet_lab.evaluation.localization.cases import LOGS

SETTINGS = {'localizer.update_period_s': 10.0}
SAID = {
    'nothing': {},
    'off by a quarter': {'pose.scale_tolerance': 0.25, 'pose.anisotropy_sigma': 0.05},
    'unknown': {'localizer.scale_policy': 'unknown'},
}


def best_over_time(run, truth):
    """Return error [m], probability and agreement of the best placement at every update."""
    rows = []
    for output in run.outputs:
        if not output.estimates:
            continue
        placed = output.estimates[0].A_plan_submap @ output.submap.T_odom_submap.inv()
        xy = run.odometry.at(np.array([output.stamp_ns]))[0].xy[0]
        error_m = np.linalg.norm(truth.A_plan_log.inv().apply(placed.apply(xy)) - xy)
        best = output.estimates[0]
        rows.append(np.round([error_m, best.probability, best.score], 3).tolist())
    return rows


def follow(folder, name, config):
    """Return the results of one log with one configuration."""
    truth = read_fitted_truth(folder, name)
    localizer = create_localizer(config)
    localizer.set_plan(truth.plan)
    register = KissOdometry(config.odometry).register_scan
    run = replay(open_scans(truth.log), localizer, config.localizer.update_period_s, register)
    summary = summarize_run(
        run.published,
        run.odometry,
        run.tick_ms,
        run.odometry,
        truth.A_plan_log,
        run.covariances,
    )
    statuses = [output.status.value for output in run.outputs]
    held = f'normalised error {summary.nees_mean}, {summary.inside_95} inside the gate'
    print(f'{name}: {statuses[-1]}; {summary}; {held}', flush=True)
    over_time = {'status_over_time': statuses, 'best_over_time': best_over_time(run, truth)}
    return summary.as_json() | over_time


def main() -> None:
    """Print one row per log and scale prior."""
    parser = script_parser(__doc__)
    parser.add_argument('folder', type=Path, help='the radish data folder')
    parser.add_argument('--set', action='append', default=[], metavar='KEY=VALUE')
    arguments = parser.parse_args()
    report = {name: {} for name in LOGS}
    for name, (said, settings) in product(LOGS, SAID.items()):
        config = load_config(None, SETTINGS | settings | parse_settings(arguments.set))
        report[name][said] = follow(arguments.folder, name, config)
    finish('real_logs', arguments.json, {'logs': report})


if __name__ == '__main__':
    main()
