# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Detection rate and false alarms of ``fpnet doctor`` on robots with and without faults.

Run: python benchmarks/doctor_faults.py [--drives 4] [--good 10] [--seed 100] [--json OUT]

The first 6 s of generated recordings, with 16, 32 and 64-beam lidars and a dome lidar in turn, are
stored as bags by robots with one fault each, and by faultless ones with and without a gyroscope.
``fpnet doctor`` examines them. A fault is named first if the first finding is of its kind.
"""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from fpnet.cli.progress import progress
from fpnet.doctor.bag import observe_bag
from fpnet.doctor.examine import examine
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.kept import make_once
from fpnet_lab.sim.drives.faulty_robots import FAULTS, RIGHT, FaultyRobot, ShortDrive, record

SENSORS = ('beams16', 'beams32', 'dome', 'beams64')
GOOD = (RIGHT, FaultyRobot(gyro_frame='imu'))
LISTEN_S = 10.0


@dataclass(frozen=True)
class ExaminedDrive:
    """A recording, and whether it is used with faults."""

    seed: int
    sensor: str
    has_faults: bool

    @property
    def name(self):
        """Unique name of the recording."""
        return f'{self.seed}_{self.has_faults}'


@dataclass(frozen=True)
class Examined:
    """Findings for one robot, as kinds in the order of the report."""

    seed: int
    sensor: str
    fault: str
    expected: str
    said: tuple[str, ...]


def run_drive(case):
    """Return the findings for every robot in one recording."""
    drive = ShortDrive.of(case.seed, case.sensor)
    robots = [(name, *each) for name, each in FAULTS.items()]
    if not case.has_faults:
        robots = [('', GOOD[case.seed % len(GOOD)], '')]
    found = []
    with TemporaryDirectory() as folder:
        for number, (name, robot, problem) in enumerate(robots):
            bag = record(Path(folder) / str(number), drive, robot)
            said = tuple(str(each.problem) for each in examine(observe_bag(bag, LISTEN_S)))
            found.append(Examined(case.seed, case.sensor, name, str(problem), said))
    return tuple(found)


def main() -> None:
    """Print how often each fault is named first, and the findings for faultless robots."""
    parser = script_parser(__doc__)
    parser.add_argument('--drives', type=int, default=4)
    parser.add_argument('--good', type=int, default=10)
    parser.add_argument('--seed', type=int, default=100)
    parser.add_argument('--workers', type=int, default=1)
    arguments = parser.parse_args()
    drives = [
        ExaminedDrive(arguments.seed + k, SENSORS[k % len(SENSORS)], k < arguments.drives)
        for k in range(arguments.drives + arguments.good)
    ]
    with progress('drives', len(drives)) as advance:
        named = {drive.name: drive for drive in drives}
        results = make_once(None, Examined, named, run_drive, arguments.workers, on_done=advance)
    examined = [each for drive in results for each in drive]
    faults = {name: summary([e for e in examined if e.fault == name]) for name in FAULTS}
    good = [each for each in examined if not each.fault]
    report = {
        'faults': faults,
        'named_always': sum(row['first'] == row['drives'] for row in faults.values()),
        'good': len(good),
        'alarms': sum(bool(each.said) for each in good),
        'said_of_good': sorted({kind for each in good for kind in each.said}),
    }
    finish('doctor_faults', arguments.json, report)


def summary(examined):
    """Return a summary of the findings for one fault."""
    others = Counter(
        each.said[0] if each.said else 'nothing'
        for each in examined
        if each.said[:1] != (each.expected,)
    )
    return {
        'is': examined[0].expected,
        'drives': len(examined),
        'first': sum(each.said[:1] == (each.expected,) for each in examined),
        'alone': sum(each.said == (each.expected,) for each in examined),
        'else': ', '.join(f'{kind} ({count})' for kind, count in others.items()),
    }


if __name__ == '__main__':
    main()
