# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Errors of the wrong acceptances of ``fpnet bench matching --set robot``.

Run: python benchmarks/wrong_claims.py ../shared/data [--split report] [--building lab_intel]
     [--band 10-20]

Prints a line per acceptance that is not within 5 degrees, 10 % of scale and 3 % of the plan's
diagonal of the fitted transform: its position error (median over the robot's free space, in the
plan's nominal metres), heading error and scale error.
"""

import argparse
from pathlib import Path

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import angle_between
from fpnet_core.localizer import MapMatchStatus, match_maps
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.submaps import submap_from_grid
from fpnet_core.types import FREE
from fpnet_lab.evaluation.matching_robot import robot_cases
from fpnet_lab.metrics.placement import RIGHT_DEG, RIGHT_DIAGONALS, RIGHT_SCALE


def errors(found, pair):
    """Return median and centre distance [nominal m], heading error [deg], and scale ratio."""
    truth = pair.A_plan_robot
    xy = pair.robot.rc_to_xy(np.argwhere(pair.robot.cells == FREE))
    placed, true = found.apply(xy), truth.apply(xy)
    turn = np.rad2deg(abs(angle_between(found.heading, truth.heading)))
    scale = found.scale / truth.scale
    moved = np.median(np.linalg.norm(placed - true, axis=1))
    return moved, np.linalg.norm(placed.mean(axis=0) - true.mean(axis=0)), turn, scale


def main() -> None:
    """Match all cases, and print the wrong acceptances."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('data', type=Path)
    parser.add_argument('--split', default='report', choices=('tune', 'report'))
    parser.add_argument('--building')
    parser.add_argument('--band')
    arguments = parser.parse_args()
    config = FpnetConfig()
    matcher = LearnedMatcher(config.matcher)
    claims = wrong = 0
    for case in robot_cases(arguments.data, arguments.split, None):
        pair = case.pair
        if arguments.building not in (None, pair.building) or arguments.band not in (
            None,
            case.band,
        ):
            continue
        metric = (pair.is_metric, pair.is_metric)
        found = match_maps(pair.plan, submap_from_grid(pair.robot), matcher, config, *metric)
        if found.status is not MapMatchStatus.MATCHED:
            continue
        claims += 1
        moved, middle, turn, scale = errors(found.A_best, pair)
        limit = RIGHT_DIAGONALS * float(np.hypot(*pair.plan.shape)) * pair.plan.resolution
        if middle > limit or turn > RIGHT_DEG or abs(scale - 1.0) > RIGHT_SCALE:
            wrong += 1
            print(
                f'{pair.name}, {case.band}: off by {moved:.2f} m (centre {middle:.2f}, limit '
                f'{limit:.2f} m), {turn:.1f} deg, scale {scale:.3f}'
            )
    print(f'{wrong} of {claims} acceptances are wrong')


if __name__ == '__main__':
    main()
