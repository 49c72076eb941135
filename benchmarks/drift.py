# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Pose error of the localizer when odometry drift without loop closure deforms the submap.

Run: python benchmarks/drift.py [--drives 6] [--sensor planar] [--seed 8101]
     [--rough-m 0.25] [--json OUT]; then fpnet bench figures drift=OUT

Recordings of three to seven minutes in larger generated buildings, exact plans, KISS-ICP odometry.
At every update while localized, two poses are compared with the truth: the placement of the whole
submap, and the published pose, which is corrected with the walls around the robot. ``odometry`` is
the error with odometry alone after a correct initial pose. Everything is repeated on rough
drawings with wrong room sizes (walls shifted by smooth noise of ``--rough-m``, independently in x
and y), and on exact ones with wheel odometry, which loses the heading in turns.
"""

from dataclasses import replace
from functools import partial
import json

from generated_drives import drives_parser, each
import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import detrend

from fpnet_core.geometry import SE2
from fpnet_core.io.scans import Scan
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_lab.cli.reports import finish
from fpnet_lab.evaluation.localization.drives import registered, run_product
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.evaluation.localization.records import Truth, robot_error
from fpnet_lab.evaluation.localization.runs import UPDATE_PERIOD_S
from fpnet_lab.sim.drives.tours import TourLimits

ROOMS = (25, 60)
SMOOTH_M = 3.0
TOUR = TourLimits(rooms=20, shortest_s=200.0, longest_s=400.0)


def drive(seed, family, sensor, config, rough_m):
    """Return one recording's results on the exact and a rough drawing, and with wheels."""
    recording = drive_through(family, sensor, seed, rooms=ROOMS, limits=TOUR)
    scans = list(registered(recording, config.odometry))
    poses = PlanarTrajectory.from_transforms(recording.stamps_ns, recording.truth())
    truth = Truth(poses, recording.A_plan_building)
    plans = {
        'exact': recording.floorplan,
        'rough': rough(recording.floorplan, rough_m, np.random.default_rng(seed)),
    }
    figures = {'family': family, 'seed': seed, 'path_m': poses.path_length_m()}
    figures |= {name: on_plan(scans, plan, config, truth) for name, plan in plans.items()}
    scans = list(on_wheels(recording))
    return figures | {'wheels': on_plan(scans, plans['exact'], config, truth)}


def on_wheels(recording):
    """Yield the scans with wheel odometry poses, which slip in turns."""
    for number, T_odom_sensor in enumerate(recording.wheel_odometry()):
        scan = recording.scan(number)
        yield Scan(scan.stamp_ns, scan.points, T_odom_sensor=T_odom_sensor)


def on_plan(scans, plan, config, truth):
    """Return the number of updates while localized, and quantiles of the pose errors."""
    product = run_product(scans, plan, config, UPDATE_PERIOD_S)
    odometry = product.replay.odometry
    errors = []
    for output in product.updates:
        if output.A_plan_odom is not None:
            whole = output.estimates[0].A_plan_submap @ output.submap.T_odom_submap.inv()
            errors.append(
                [
                    robot_error(output.stamp_ns, A, odometry, truth)
                    for A in (first_pose(odometry, truth), whole, output.A_plan_odom)
                ]
            )
    figures = {'claimed_ticks': len(errors)}
    if errors:
        table = np.array(errors) * [1.0, np.rad2deg(1.0)]  # (updates, 3, 2)
        for number, name in enumerate(('odometry', 'whole_submap', 'published')):
            middle, p95, most = np.quantile(table[:, number], [0.5, 0.95, 1.0], axis=0)
            figures[name] = {
                'p50_m': middle[0], 'p95_m': p95[0], 'p95_deg': p95[1], 'max_m': most[0],
                'max_deg': most[1],
            }  # fmt: skip
    return figures


def rough(plan, sigma_m, rng):
    """Return a drawing with straight, parallel walls at wrong distances."""
    row, col = (wavy(size, plan.resolution, sigma_m, rng) for size in plan.cells.shape)
    return replace(plan, cells=plan.cells[np.ix_(row, col)])


def wavy(size, resolution, sigma_m, rng):
    """Return indices shifted by smooth noise without overall shift and stretch."""
    noise = detrend(gaussian_filter1d(rng.normal(size=size), SMOOTH_M / resolution))
    shifted = np.arange(size) + sigma_m / resolution * noise / noise.std()
    return np.clip(np.rint(shifted).astype(int), 0, size - 1)


def first_pose(odometry, truth):
    """Return the placement that is correct at the first scan."""
    (true, _), start = truth.poses.at(odometry.stamps_ns[:1]), odometry
    T_truth_robot = SE2.from_xy_yaw(*true.xy[0], float(true.yaw[0]))
    T_odom_robot = SE2.from_xy_yaw(*start.xy[0], float(start.yaw[0]))
    return truth.A_plan_truth @ T_truth_robot @ T_odom_robot.inv()


def main() -> None:
    """Print one line per recording, and write the results as JSON if requested."""
    parser, results = drives_parser(__doc__, drives=6, seed=8101), []
    parser.add_argument('--rough-m', type=float, default=0.25)
    arguments = parser.parse_args()
    for _, figures in each(arguments, partial(drive, rough_m=arguments.rough_m)):
        results.append(figures)
        print(json.dumps(figures), flush=True)
    finish('drift', arguments.json, {'drives': results})


if __name__ == '__main__':
    main()
