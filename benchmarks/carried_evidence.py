# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What tells a robot that was carried off from one that was not? Fits the weights of both signs.

Run: python benchmarks/carried_evidence.py [--drives 12] [--seed 8401] [--rows FILE]

Drives as of ``carried_off.py``, of other seeds, by a planar scanner and a lidar of 16 beams, and
long ones with drift as of ``drift.py``, on exact and on rough drawings. Nobody doubts the claim
here: every tick under it gives the support of the newest returns beside the usual one, and the
share of them in what was free. A logistic regression tells the first looks after the robot was
lifted from all looks before; ``fpnet_core/localizer/surroundings.py`` holds its weights.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, field
import json
from pathlib import Path
from unittest import mock

from carried_off import TOUR, carried
import drift
from generated_drives import FAMILIES
import numpy as np
from scipy.optimize import minimize

from fpnet_core.config import FpnetConfig
from fpnet_core.localizer.kidnap import KidnapDetector, signs_of
from fpnet_lab.evaluation.localization.drives import registered, run_product
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.evaluation.localization.runs import UPDATE_PERIOD_S

ROUGH_M = 0.25
FIRST_LOOKS = 3  # after that, the robot is where the submap knows nothing, or looks the same
PRIOR = 1e-4  # numerical: keeps the weights finite where the looks can be told without error


@dataclass(eq=False)
class Watching:
    """Never doubts, and notes the signs of every look."""

    lifted_ns: int | None = None
    rows: list[tuple[bool, float, float]] = field(default_factory=list)
    after: int = 0
    frozen: tuple = ()

    def is_doubtful(self, support, usual, kidnap_state, submap) -> bool:
        """Note the signs; what was usual stays that of the ride before."""
        is_after = self.lifted_ns is not None and submap.stamp_ns > self.lifted_ns
        self.frozen = self.frozen if is_after and self.frozen else (usual, kidnap_state.before)
        usual, before = self.frozen
        self.after += is_after
        if support is not None and before is not None and self.after <= FIRST_LOOKS:
            self.rows.append((is_after, *signs_of(support, usual, before, submap)))
        return False


def looks(scans, plan, config, lifted_ns=None) -> list[tuple[bool, float, float]]:
    """Return of each look whether the robot was lifted, and both signs."""
    watching = Watching(lifted_ns)
    judged_so = mock.patch.object(
        KidnapDetector, '_is_doubtful', lambda _, *given: watching.is_doubtful(*given)
    )
    with judged_so:
        run_product(scans, plan, config, UPDATE_PERIOD_S)
    return watching.rows


def gather(seed: int, count: int) -> Iterator[tuple[str, list]]:
    """Yield the looks of one drive after another, with a name."""
    config = FpnetConfig()
    for number in range(count):
        family = FAMILIES[number % len(FAMILIES)]
        for sensor, first in (('planar', seed), ('beams16', seed + 1000)):
            recording = drive_through(family, sensor, first + number, limits=TOUR)
            scans, _, lifted_ns = carried(list(registered(recording, config.odometry)))
            name = f'carried off, {sensor}, {family}'
            yield name, looks(scans, recording.floorplan, config, lifted_ns)
    for number in range(count // 2):
        family = FAMILIES[number % len(FAMILIES)]
        recording = drive_through(
            family, 'planar', seed + 2000 + number, rooms=drift.ROOMS, limits=drift.TOUR
        )
        scans = list(registered(recording, config.odometry))
        rough = drift.rough(recording.floorplan, ROUGH_M, np.random.default_rng(seed + number))
        for name, plan in {'exact': recording.floorplan, 'rough': rough}.items():
            yield f'drift, {name}, {family}', looks(scans, plan, config)


def main() -> None:
    """Gather and print the weights, and what they make of the looks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--drives', type=int, default=12)
    parser.add_argument('--seed', type=int, default=8401)
    parser.add_argument('--rows', type=Path, help='keep the looks here; read them if it exists')
    arguments = parser.parse_args()
    if arguments.rows and arguments.rows.exists():
        rows = json.loads(arguments.rows.read_text(encoding='utf-8'))
    else:
        rows = []
        for name, found in gather(arguments.seed, arguments.drives):
            print(f'{name}: {len(found)} looks', flush=True)
            rows += found
        if arguments.rows:
            arguments.rows.write_text(json.dumps(rows), encoding='utf-8')
    fit(np.array(rows, dtype=np.float64))


def fit(rows) -> None:
    """Print the weights and the errors that they make, both classes counting the same."""
    is_after, signs = rows[:, 0] > 0.0, np.insert(rows[:, 1:], 0, 1.0, axis=1)
    share = np.where(is_after, 0.5 / is_after.sum(), 0.5 / (~is_after).sum())
    side = np.where(is_after, 1.0, -1.0)

    def surprise(weights):
        return share @ np.logaddexp(0.0, -side * (signs @ weights)) + PRIOR * weights @ weights

    weights = minimize(surprise, np.zeros(3)).x
    print(f'weights: {", ".join(f"{weight:.1f}" for weight in weights)}')
    says = signs @ weights > 0.0
    print(f'{(says & ~is_after).sum()} of {(~is_after).sum()} looks before are doubted')
    print(f'{(says & is_after).sum()} of {is_after.sum()} looks after')


if __name__ == '__main__':
    main()
