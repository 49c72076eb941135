# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Poses that the seeder gives another localizer: kidnapped robots, and whether covariances hold.

Run: python benchmarks/seeder.py [--drives 10] [--sensor planar] [--seed 9101] [--starts 6]
     [--json OUT]; then fpnet bench figures seeder=OUT

Generated buildings, exact plans, KISS-ICP odometry. As in ``carried_off.py``, each robot is lifted
once and set down elsewhere. A particle filter with AMCL's semantics tracks it; the decisions of
the node ``seeder`` are made after every scan from the published poses of both. A seed is wrong
beyond 3 m or 30 degrees; the filter is right within 1 m and 10 degrees at the end.

Then the localizer starts anew at ``--starts`` places of the unbroken path, on the exact plan and
on a sketch in turn; each first pose counts as a seed in the share inside the 95 % ellipsoid of its
covariance (x, y, yaw).
"""

from itertools import cycle, islice
import json

from carried_off import TOUR, carried
from generated_drives import drives_parser, each
import numpy as np

from fpnet.accuracy import GATE_95, WRONG_POSITION_M, WRONG_YAW_RAD, normalised_errors
from fpnet_core.geometry import SE2, angle_between
from fpnet_core.localizer import create_localizer
from fpnet_core.localizer.replay import Replay
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import Status
from fpnet_lab.baselines.amcl import Amcl
from fpnet_lab.cli.reports import finish, write_report
from fpnet_lab.evaluation.localization.cases import Distortion
from fpnet_lab.evaluation.localization.drives import registered, run_product
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.evaluation.localization.plans import draw_plan
from fpnet_lab.evaluation.localization.runs import UPDATE_PERIOD_S
from fpnet_ros.seeding import SeedingState, Situation, advise
from fpnet_ros.settings import SeederParameters
from msg_adapters.poses import StampedPose, UncertainPose

RIGHT_M, RIGHT_RAD = 1.0, np.deg2rad(10.0)


def drive(seed, family, sensor, config, starts):
    """Return what happens to one robot, and the squared errors of first poses."""
    recording = drive_through(family, sensor, seed, limits=TOUR)
    unbroken = list(registered(recording, config.odometry))
    scans, true_ns, lifted_ns = carried(unbroken)
    truth = PlanarTrajectory.from_transforms(recording.stamps_ns, recording.truth())
    on_plan = truth.mapped(recording.A_plan_building)
    moved, _ = on_plan.at(true_ns)
    place = PlanarTrajectory(np.array([scan.stamp_ns for scan in scans]), moved.xy, moved.yaw)
    product = run_product(scans, recording.floorplan, config, UPDATE_PERIOD_S)
    told = accompanied(product, scans, place, np.random.default_rng(seed))
    first = first_poses(recording, unbroken, truth, config, starts)
    return {'family': family, 'seed': seed} | scored(told, lifted_ns) | first


def accompanied(product, scans, place, rng):
    """Return the seeds and the filter's last pose, each with stamp and errors."""
    other, state, limits = Amcl(product.plan.evidence, rng), SeedingState(), SeederParameters()
    statuses = {output.stamp_ns: output.status for output in product.replay.outputs}
    published = product.run.published
    ours_by_ns = {
        int(ns): UncertainPose(
            StampedPose(int(ns), 'map', SE2.from_xy_yaw(*published.xy[k], published.yaw[k])),
            product.run.covariances[k],
        )
        for k, ns in enumerate(published.stamps_ns)
    }
    status, seeds, tracked, ours = None, [], None, None
    for scan in scans:
        ns = scan.stamp_ns
        status = statuses.get(ns, status)
        ours = ours_by_ns.get(ns, ours if status is Status.LOCALIZED else None)
        mean = other.add_scan(scan.points, scan.T_odom_sensor, ns)
        pair = None
        if mean is not None:
            state = state.has_heard()
            tracked = errors(place, ns, mean.T_plan_base)
            pose = UncertainPose(StampedPose(ns, 'map', mean.T_plan_base), mean.cov)
            pair = (ours_by_ns[ns], pose) if ns in ours_by_ns else None
        state, advice = advise(state, Situation(ns, status, ours, pair), limits)
        if advice.seed:
            other.take_initial_pose(ours.pose.T_frame_body, ours.cov, ours.pose.stamp_ns)
            seeds.append(errors(place, ours.pose.stamp_ns, ours.pose.T_frame_body))
    return {'seeds': seeds, 'tracked': tracked}


def errors(place, stamp_ns, T_plan_base):
    """Return stamp, position [m] and yaw [rad] errors of a pose."""
    k = int(np.searchsorted(place.stamps_ns, stamp_ns))
    metres = float(np.linalg.norm(T_plan_base.translation - place.xy[k]))
    return int(stamp_ns), metres, float(angle_between(T_plan_base.yaw, place.yaw[k]))


def scored(told, lifted_ns):
    """Return the figures of one robot."""
    seeds, tracked = told['seeds'], told['tracked']
    after = [ns for ns, _, _ in seeds if ns > lifted_ns]
    return {
        'seeds': len(seeds),
        'seeded_before': len(seeds) > len(after),
        'reseeded': bool(after),
        'reseeded_s': float(after[0] - lifted_ns) / NS_PER_S if after else None,
        'wrong_seeds': sum(
            bool(m > WRONG_POSITION_M or rad > WRONG_YAW_RAD) for _, m, rad in seeds
        ),
        'is_right_at_the_end': bool(tracked)
        and bool(tracked[1] <= RIGHT_M and tracked[2] <= RIGHT_RAD),
    }


def first_poses(recording, scans, truth, config, starts):
    """Return the squared errors of first poses from many starts, and the number of wrong ones."""
    sketch = draw_plan(recording.building.plan, Distortion.SKETCH, recording.seed)
    plans = (
        ('exact', recording.floorplan, recording.A_plan_building),
        ('sketch', sketch.grid, sketch.A_plan_building),
    )
    squared, wrong = {name: [] for name, _, _ in plans}, 0
    begins = np.linspace(0, len(scans), starts, endpoint=False).astype(int)
    for begin, (name, plan, A_plan_building) in zip(begins, cycle(plans), strict=False):
        localizer = create_localizer(config)
        localizer.set_plan(plan)
        replay = Replay(islice(scans, begin, None), localizer, UPDATE_PERIOD_S, None)
        if not any(output.status is Status.LOCALIZED for output in replay):
            continue
        run = replay.result()
        if not len(run.published):
            continue
        first = run.published.take(np.array([-1]))
        found = normalised_errors(first, run.covariances[-1:], truth, A_plan_building)
        squared[name] += found.tolist()
        wrong += len(first) - len(found)
    return {'squared': squared, 'wrong_firsts': wrong}


def report(robots):
    """Return the report, with the totals of all robots."""
    waits = [robot['reseeded_s'] for robot in robots if robot['reseeded']]
    wrong = sum(robot['wrong_firsts'] for robot in robots)
    totals = {
        'kidnaps': sum(robot['seeded_before'] for robot in robots),
        'reseeded': sum(robot['reseeded'] and robot['seeded_before'] for robot in robots),
        'reseeded_s_median': float(np.median(waits)) if waits else None,
        'reseeded_s_max': max(waits, default=None),
        'seeds': sum(robot['seeds'] for robot in robots),
        'wrong_seeds': sum(robot['wrong_seeds'] for robot in robots),
        'right_at_the_end': sum(robot['is_right_at_the_end'] for robot in robots),
        'wrong_first_poses': wrong,
    }
    for name in ('exact', 'sketch'):
        squared = np.array([each for robot in robots for each in robot['squared'][name]])
        totals[name] = {
            'first_poses': len(squared),
            'nees_mean': float(squared.mean()) if len(squared) else None,
            'inside_95': float((squared <= GATE_95).mean()) if len(squared) else None,
        }
    return {'drives': robots, 'totals': totals}


def main() -> None:
    """Print one line per robot, and the totals."""
    parser = drives_parser(__doc__, drives=10, seed=9101)
    parser.add_argument('--starts', type=int, default=6, help='places per recording')
    arguments, robots = parser.parse_args(), []
    for _, robot in each(arguments, lambda *given: drive(*given, starts=arguments.starts)):
        print(json.dumps({k: v for k, v in robot.items() if k != 'squared'}), flush=True)
        robots.append(robot)
        write_report(arguments.json, report(robots))
    finish('seeder', arguments.json, report(robots))


if __name__ == '__main__':
    main()
