# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Time until the localizer notices that the robot was kidnapped (lifted and set down elsewhere).

Run: python benchmarks/carried_off.py [--drives 12] [--sensor planar] [--seed 8201]
     [--json OUT]; then fpnet bench figures carried_off=OUT

Generated buildings, exact plans, KISS-ICP odometry. After 45 % of the path, the recording
continues from a place at least 8 m away (70 % of the largest distance if that is less). Odometry
continues without a jump, so the localizer is not notified. Everything is repeated without kidnap
detection (``localizer.doubt_probability=1``).
"""

import json

from generated_drives import drives_parser, each
import numpy as np

from fpnet.accuracy import WRONG_POSITION_M, WRONG_YAW_RAD, pose_errors
from fpnet_core.io.scans import Scan
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory, lengths_along
from fpnet_core.types import Status
from fpnet_lab.cli.reports import finish
from fpnet_lab.evaluation.localization.drives import registered, run_product
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.evaluation.localization.runs import UPDATE_PERIOD_S
from fpnet_lab.sim.drives.tours import TourLimits

TOUR = TourLimits(rooms=4, shortest_s=70.0, longest_s=110.0)
CARRIED_AT, CARRIED_M, FARTHEST = 0.45, 8.0, 0.7
WAYS = {'asked': {}, 'not_asked': {'doubt_probability': 1.0}}


def carried(scans):
    """Return scans with a part of the path skipped, original stamps, and the lift's stamp."""
    poses = np.array([scan.T_odom_sensor for scan in scans])
    xy = poses[:, :2, 3]
    path = lengths_along(xy)
    lifted = int(np.searchsorted(path, CARRIED_AT * path[-1]))
    away = np.linalg.norm(xy[lifted:] - xy[lifted], axis=1)
    down = lifted + int(np.argmax(away > min(CARRIED_M, FARTHEST * away.max())))
    shift = poses[lifted] @ np.linalg.inv(poses[down])
    gap_ns = scans[down].stamp_ns - scans[lifted + 1].stamp_ns
    moved = [
        Scan(scan.stamp_ns - gap_ns, scan.points, T_odom_sensor=shift @ scan.T_odom_sensor)
        for scan in scans[down:]
    ]
    stamps_ns = [scan.stamp_ns for scan in (*scans[: lifted + 1], *scans[down:])]
    return [*scans[: lifted + 1], *moved], np.array(stamps_ns), scans[lifted].stamp_ns


def drive(seed, family, sensor, config):
    """Return the results of one recording, for each way that is localized when lifted."""
    recording = drive_through(family, sensor, seed, limits=TOUR)
    scans, true_ns, lifted_ns = carried(list(registered(recording, config.odometry)))
    figures = {}
    for way, update in WAYS.items():
        settings = config.model_copy(
            update={'localizer': config.localizer.model_copy(update=update)}
        )
        product = run_product(scans, recording.floorplan, settings, UPDATE_PERIOD_S)
        after = claims_after(product.replay.outputs, lifted_ns)
        if after is not None:
            wrong, right = scored(product.run.published, scans, true_ns, recording, lifted_ns)
            figures[way] = after | {'wrong_poses': wrong, 'right_poses': right}
    return {'family': family, 'seed': seed, **figures}


def claims_after(outputs, lifted_ns):
    """Return when the pose was withheld and whether it came back; None if not localized before."""
    states = [(o.stamp_ns, o.status is Status.LOCALIZED) for o in outputs]
    before = [is_accepted for stamp, is_accepted in states if stamp <= lifted_ns]
    if not before or not before[-1]:
        return None
    after = [((stamp - lifted_ns) / NS_PER_S, is_localized) for stamp, is_localized in states]
    after = [(seconds, is_localized) for seconds, is_localized in after if seconds > 0.0]
    withheld_s = next((seconds for seconds, is_localized in after if not is_localized), None)
    return {'seconds': after[-1][0], 'withheld_s': withheld_s, 'is_found': after[-1][1]}


def scored(published, scans, true_ns, recording, lifted_ns):
    """Return the numbers of wrong and of right poses after the robot was lifted."""
    when = np.searchsorted([scan.stamp_ns for scan in scans], published.stamps_ns)
    is_after = published.stamps_ns > lifted_ns
    poses = PlanarTrajectory(true_ns[when], published.xy, published.yaw)
    poses = poses.take(is_after)
    truth = PlanarTrajectory.from_transforms(recording.stamps_ns, recording.truth())
    metres, radians = pose_errors(poses.mapped(recording.A_plan_building.inv()), truth)
    wrong = (metres > WRONG_POSITION_M) | (radians > WRONG_YAW_RAD)
    return int(wrong.sum()), int((~wrong).sum())


def sums(results):
    """Return the totals of all recordings of one way."""
    seconds = [r['withheld_s'] for r in results if r['withheld_s'] is not None]
    return {
        'localized': len(results),
        'withheld': len(seconds),
        'withheld_s_median': float(np.median(seconds)) if seconds else None,
        'withheld_s_max': max(seconds, default=None),
        'found_again': sum(r['is_found'] and r['withheld_s'] is not None for r in results),
        'wrong_poses': sum(r['wrong_poses'] for r in results),
        'right_poses': sum(r['right_poses'] for r in results),
    }


def main() -> None:
    """Print one line per recording, and the totals."""
    arguments, results = drives_parser(__doc__, drives=12, seed=8201).parse_args(), []
    for _, figures in each(arguments, drive):
        print(json.dumps(figures), flush=True)
        results.append(figures)
    ways = {way: sums([each[way] for each in results if way in each]) for way in WAYS}
    finish('carried_off', arguments.json, {'drives': results, 'ways': ways})


if __name__ == '__main__':
    main()
