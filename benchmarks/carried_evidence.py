# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fit of the two feature weights that detect a kidnapped robot.

Run: python benchmarks/carried_evidence.py [--drives 12] [--seed 8401] [--rows FILE]

Recordings as in ``carried_off.py`` with other seeds, with a planar scanner and a 16-beam lidar,
and long ones as in ``drift.py``, on exact and rough drawings. Kidnap detection is disabled: every
update while localized gives the newest returns' support relative to the usual support, and their
share in previously free space. A logistic regression separates the first updates after the lift
from all updates before; ``fpnet_core/localizer/kidnap.py`` contains its weights.
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
FIRST_LOOKS = 3  # later, the robot is in unmapped space, or the submap looks the same
PRIOR = 1e-4  # numerical: keeps the weights finite if the updates are separable


@dataclass(eq=False)
class Watching:
    """Replacement of the kidnap test that never triggers and records the features."""

    lifted_ns: int | None = None
    rows: list[tuple[bool, float, float]] = field(default_factory=list)
    after: int = 0
    frozen: tuple = ()

    def is_doubtful(self, support, usual, kidnap_state, submap) -> bool:
        """Record the features, with the usual support frozen when the robot is lifted."""
        is_after = self.lifted_ns is not None and submap.stamp_ns > self.lifted_ns
        self.frozen = self.frozen if is_after and self.frozen else (usual, kidnap_state.before)
        usual, before = self.frozen
        self.after += is_after
        if support is not None and before is not None and self.after <= FIRST_LOOKS:
            self.rows.append((is_after, *signs_of(support, usual, before, submap)))
        return False


def looks(scans, plan, config, lifted_ns=None) -> list[tuple[bool, float, float]]:
    """Return for each update whether the robot was lifted, and both features."""
    watching = Watching(lifted_ns)
    patched = mock.patch.object(
        KidnapDetector, '_is_doubtful', lambda _, *given: watching.is_doubtful(*given)
    )
    with patched:
        run_product(scans, plan, config, UPDATE_PERIOD_S)
    return watching.rows


def gather(seed: int, count: int) -> Iterator[tuple[str, list]]:
    """Yield a name and the updates of one recording after another."""
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
    """Gather the updates, fit the weights and print them with their errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--drives', type=int, default=12)
    parser.add_argument('--seed', type=int, default=8401)
    parser.add_argument('--rows', type=Path, help='store the updates here; read them if it exists')
    arguments = parser.parse_args()
    if arguments.rows and arguments.rows.exists():
        rows = json.loads(arguments.rows.read_text(encoding='utf-8'))
    else:
        rows = []
        for name, found in gather(arguments.seed, arguments.drives):
            print(f'{name}: {len(found)} updates', flush=True)
            rows += found
        if arguments.rows:
            arguments.rows.write_text(json.dumps(rows), encoding='utf-8')
    fit(np.array(rows, dtype=np.float64))


def fit(rows) -> None:
    """Fit and print the weights and their errors, with equal weight of both classes."""
    is_after, signs = rows[:, 0] > 0.0, np.insert(rows[:, 1:], 0, 1.0, axis=1)
    share = np.where(is_after, 0.5 / is_after.sum(), 0.5 / (~is_after).sum())
    side = np.where(is_after, 1.0, -1.0)

    def surprise(weights):
        return share @ np.logaddexp(0.0, -side * (signs @ weights)) + PRIOR * weights @ weights

    weights = minimize(surprise, np.zeros(3)).x
    print(f'weights: {", ".join(f"{weight:.1f}" for weight in weights)}')
    detected = signs @ weights > 0.0
    print(f'false alarms: {(detected & ~is_after).sum()} of {(~is_after).sum()} updates before')
    print(f'detections: {(detected & is_after).sum()} of {is_after.sum()} updates after')


if __name__ == '__main__':
    main()
