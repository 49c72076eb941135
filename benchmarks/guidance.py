# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Distance that a robot drives until it is localized, with and without the localizer's guidance.

Run: python benchmarks/guidance.py [--buildings 20] [--seed 3000] [--json OUT] [--work DIR]

Generated buildings with repeated rooms, or with two equal halves that only their surroundings
distinguish, if at all. They are unfurnished, as local obstacle avoidance is out of scope. A robot
with 16 beams and true odometry starts at a random place and explores: following the localizer's
guidance, to the nearest frontier, or to a random frontier (mean of three runs). It stops after
60 m, which counts as 60 m. Buildings in which no robot was localized are counted separately.
"""

from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from fpnet.cli.progress import progress
from fpnet_core.config import FpnetConfig
from fpnet_core.localizer import Localizer
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.evaluation.exploring import POLICIES, explore
from fpnet_lab.kept import make_once
from fpnet_lab.sim.drives.recording import RecordingOptions, make_recording
from fpnet_lab.sim.lidars.sensors import SENSORS

MOST_M = 60.0
FAMILIES = ('repeated', 'repeated', 'turned', 'repeated', 'mirrored')
RUNS = {'advice': 1, 'nearest': 1, 'random': 3}
WRONG_M = 3.0


@dataclass(frozen=True)
class Explorer:
    """A building, an exploration policy, and the number of the run."""

    family: str
    seed: int
    policy: str
    run: int

    @property
    def name(self):
        """Name of the result's file."""
        return f'{self.family}_{self.seed}_{self.policy}_{self.run}'


@dataclass(frozen=True)
class ExploredBuilding:
    """Result of one exploration: metres to the first pose, and whether it was wrong."""

    family: str
    seed: int
    policy: str
    run: int
    found_after_m: float | None
    is_wrong: bool
    advised: float


def run_case(case):
    """Explore one building once and return the result."""
    config = FpnetConfig()
    options = RecordingOptions(
        family=case.family, rooms=(10, 30), is_furnished=False, lidar=SENSORS['beams16']
    )
    recording = make_recording(case.seed, options, 1)
    localizer = Localizer(config, LearnedMatcher(config.matcher))
    localizer.set_plan(recording.floorplan)
    found = explore(recording, localizer, POLICIES[case.policy], MOST_M, case.run)
    return ExploredBuilding(
        **asdict(case),
        found_after_m=found.found_after_m,
        is_wrong=found.found_after_m is not None and found.off_m > WRONG_M,
        advised=found.advised,
    )


def main() -> None:
    """Print the distances of each policy."""
    parser = script_parser(__doc__)
    parser.add_argument('--buildings', type=int, default=20)
    parser.add_argument('--seed', type=int, default=3000)
    parser.add_argument('--work', type=Path, metavar='DIR', help='store results here')
    parser.add_argument('--workers', type=int, default=1)
    arguments = parser.parse_args()
    cases = [
        Explorer(FAMILIES[k % len(FAMILIES)], arguments.seed + k, policy, run)
        for k in range(arguments.buildings)
        for policy, runs in RUNS.items()
        for run in range(runs)
    ]
    with progress('drives', len(cases)) as advance:
        named = {case.name: case for case in cases}
        results = make_once(
            arguments.work, ExploredBuilding, named, run_case, arguments.workers, on_done=advance
        )
    found = {result.seed for result in results if result.found_after_m is not None}
    kept = [result for result in results if result.seed in found]
    report = {
        'most_m': MOST_M,
        'nowhere': arguments.buildings - len(found),
        'policies': {policy: summary([r for r in kept if r.policy == policy]) for policy in RUNS},
        'drives': [asdict(result) for result in results],
    }
    finish('guidance', arguments.json, report)


def summary(results):
    """Return the totals of one policy, with equal weight of all buildings."""
    driven = {}
    for result in results:
        metres = MOST_M if result.found_after_m is None else result.found_after_m
        driven.setdefault(result.seed, []).append(metres)
    means = [float(np.mean(each)) for each in driven.values()]
    return {
        'buildings': len(means),
        'localised': float(np.mean([r.found_after_m is not None for r in results])),
        'mean_m': float(np.mean(means)),
        'median_m': float(np.median(means)),
        'wrong': sum(r.is_wrong for r in results),
    }


if __name__ == '__main__':
    main()
