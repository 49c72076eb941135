#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Published poses while the localizer's inputs are faulty, and the time to recover.

Run: python benchmarks/faults.py [--drives 10] [--seed 9300] [--only FAULT,FAULT] [--workers 1]
     [--work FOLDER] [--json OUT]; then fpnet bench figures faults=OUT

Recordings in generated buildings on exact plans, with a planar scanner and every fourth one with
a 16-beam lidar, and an update every second. Halfway, one of these faults occurs:

none, none_wheels, none_large
    No fault, with KISS-ICP, with wheel odometry and in a large building: the baselines for the
    other faults.
gap
    No scans for 5 s while the robot continues to drive; KISS-ICP.
slipped
    Wheel slip: within 5 s, wheel odometry reports 3 m and 40 degrees too much.
turned, shifted
    Between two scans, wheel odometry rotates by 10 to 30 degrees or jumps by 0.5 to 2 m, and
    continues from there.
exchanged
    Another building's floorplan for 5 s, then the correct one again; KISS-ICP, large buildings.
carried
    The robot is lifted and set down 8 m away, and its odometry continues; KISS-ICP.

A pose is off if its error exceeds 1 m or 10 degrees, and wrong above 3 m or 30 degrees.
``longest`` is the longest uninterrupted time with poses that are off, ``recovery`` the time from
the end of the fault until poses are right and remain so for 1 s. ``--work`` stores the scans with
their poses for the next run.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
import functools
from itertools import pairwise
import json
from pathlib import Path
from typing import Any

from carried_off import carried
from generated_drives import FAMILIES, drives_parser
import numpy as np

from fpnet.accuracy import WRONG_POSITION_M, WRONG_YAW_RAD, pose_errors
from fpnet.cli.common import load
from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import SE2
from fpnet_core.io.scans import Scan
from fpnet_core.localizer import Localizer, create_localizer
from fpnet_core.localizer.replay import Replay
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory, lengths_along
from fpnet_core.types import GridMap, Status
from fpnet_lab.cli.reports import finish
from fpnet_lab.evaluation.localization.drives import registered
from fpnet_lab.evaluation.localization.inputs import ROOMS, drive_through
from fpnet_lab.pool import each_done
from fpnet_lab.sim.drives.recording import Recording
from fpnet_lab.sim.drives.tours import TourLimits

TOUR = TourLimits(rooms=3, shortest_s=32.0, longest_s=44.0)
SENSORS = ('planar', 'planar', 'planar', 'beams16')
LARGE = (30, 60)  # rooms, so that the robot observes less than half of the floorplan
IN_LARGE = ('exchanged', 'none_large')
FAULT_AT, GAP_S = 0.5, 5.0
TURNED_DEG, SHIFTED_M = (10.0, 30.0), (0.5, 2.0)
SLIP_S, SLIPPED_M, SLIPPED_DEG = 5.0, 3.0, 40.0
OFF_M, OFF_RAD, STAYS_S = 1.0, np.deg2rad(10.0), 1.0
_ODOMETRY = FpnetConfig().odometry
TOGETHER_S = 0.25  # shorter intervals between poses count as uninterrupted


@dataclass(frozen=True, eq=False)
class Faulty:
    """
    A recording with a fault: ``scans`` with poses, and the fault's start and end.

    ``true_ns`` are the stamps of each scan in the ground truth. ``on_scan`` is called with the
    stamp of each scan before it is used.
    """

    scans: list[Scan]
    true_ns: np.ndarray
    began_ns: int
    ended_ns: int
    on_scan: Callable[[Localizer, int], None] = lambda localizer, stamp_ns: None


class Made:
    """Data shared by the faults of one recording; everything is computed once."""

    def __init__(
        self, seed: int, family: str, sensor: str, work: Path | None, is_large: bool = False
    ) -> None:
        rooms = LARGE if is_large else ROOMS
        self.recording = drive_through(family, sensor, seed, rooms=rooms, limits=TOUR)
        self._seed, self._family = seed, family
        name = f'{seed}_{sensor}' + ('_large' if is_large else '')
        self._work = None if work is None else work / name
        path = lengths_along(self.recording.truth()[:, :2, 3])
        self.half = int(np.searchsorted(path, FAULT_AT * path[-1]))
        self.half_ns = int(self.recording.stamps_ns[self.half])

    @functools.cached_property
    def raw(self) -> list[Scan]:
        """All scans without poses."""
        return [replace(scan, T_odom_sensor=None) for scan in self.recording]

    @functools.cached_property
    def by_kiss(self) -> list[Scan]:
        """All scans with KISS-ICP poses."""
        return self._kept('kiss', lambda: registered(self.raw, _ODOMETRY))

    @functools.cached_property
    def by_wheels(self) -> list[Scan]:
        """All scans with wheel odometry poses."""
        poses = self.recording.wheel_odometry()
        pairs = zip(self.raw, poses, strict=True)
        return self._kept('wheels', lambda: (replace(s, T_odom_sensor=T) for s, T in pairs))

    def without(self, until_ns: int) -> list[Scan]:
        """Return scans with KISS-ICP poses, without those from halfway until ``until_ns``."""
        is_left = lambda scan: not self.half_ns < scan.stamp_ns < until_ns  # noqa: E731
        return self._kept(
            f'gap_{until_ns}', lambda: registered(filter(is_left, self.raw), _ODOMETRY)
        )

    def rng(self, fault: str) -> np.random.Generator:
        """Return the random generator of a fault's size."""
        return np.random.default_rng((self._seed, *map(ord, fault)))

    def _kept(self, name: str, make: Callable[[], Iterable[Scan]]) -> list[Scan]:
        """Return stored scans, or make and store them."""
        path = None if self._work is None else self._work / f'{name}.npz'
        if path is not None and path.exists():
            return read_scans(path)
        scans = [Scan(s.stamp_ns, s.points, T_odom_sensor=s.T_odom_sensor) for s in make()]
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_scans(path, scans)
        return scans

    @functools.cached_property
    def other_plan(self) -> GridMap:
        """Another building's floorplan."""
        return drive_through(self._family, 'planar', self._seed + 500, limits=TOUR).floorplan

    def whole(self, scans: list[Scan]) -> Faulty:
        """Return a recording without a fault, with all of its scans."""
        stamps_ns = np.array([scan.stamp_ns for scan in scans])
        return Faulty(scans, stamps_ns, self.half_ns, self.half_ns)


def write_scans(path: Path, scans: list[Scan]) -> None:
    """Write scans with their poses."""
    np.savez(
        path,
        stamps_ns=[scan.stamp_ns for scan in scans],
        poses=[scan.T_odom_sensor for scan in scans],
        ends=np.cumsum([len(scan.points) for scan in scans]),
        points=np.concatenate([scan.points for scan in scans]),
    )


def read_scans(path: Path) -> list[Scan]:
    """Read scans written by :func:`write_scans`."""
    with np.load(path) as kept:
        clouds = np.split(kept['points'], kept['ends'][:-1])
        each = zip(kept['stamps_ns'], clouds, kept['poses'], strict=True)
        return [Scan(int(stamp_ns), xyz, T_odom_sensor=T) for stamp_ns, xyz, T in each]


def with_gap(made: Made) -> Faulty:
    """Return the recording without the scans of ``GAP_S``."""
    until_ns = made.half_ns + int(GAP_S * NS_PER_S)
    scans = made.without(until_ns)
    stamps_ns = np.array([scan.stamp_ns for scan in scans])
    return Faulty(scans, stamps_ns, made.half_ns, int(stamps_ns[stamps_ns >= until_ns][0]))


def moved(made: Made, x_m: float, y_m: float, yaw_rad: float) -> Faulty:
    """Return the recording with wheel odometry that jumps by a motion in the robot's frame."""
    drive = made.whole(made.by_wheels)
    at = drive.scans[made.half].T_odom_sensor
    jump = at @ SE2.from_xy_yaw(x_m, y_m, yaw_rad).as_matrix4() @ np.linalg.inv(at)
    after = [replace(s, T_odom_sensor=jump @ s.T_odom_sensor) for s in drive.scans[made.half :]]
    return replace(drive, scans=[*drive.scans[: made.half], *after])


def turned(made: Made) -> Faulty:
    """Return the recording with wheel odometry whose heading jumps."""
    rng = made.rng('turned')
    return moved(made, 0.0, 0.0, np.deg2rad(rng.uniform(*TURNED_DEG)) * rng.choice([-1.0, 1.0]))


def shifted(made: Made) -> Faulty:
    """Return the recording with wheel odometry whose position jumps."""
    rng = made.rng('shifted')
    way, way_rad = rng.uniform(*SHIFTED_M), rng.uniform(-np.pi, np.pi)
    return moved(made, way * np.cos(way_rad), way * np.sin(way_rad), 0.0)


def slipped(made: Made) -> Faulty:
    """Return the recording with wheels that slip for ``SLIP_S``: every step is too long."""
    drive = made.whole(made.by_wheels)
    ended_ns = drive.began_ns + int(SLIP_S * NS_PER_S)
    scans, T_now = [drive.scans[0]], drive.scans[0].T_odom_sensor
    for before, scan in pairwise(drive.scans):
        step = np.linalg.inv(before.T_odom_sensor) @ scan.T_odom_sensor
        if drive.began_ns < scan.stamp_ns <= ended_ns:
            share = (scan.stamp_ns - before.stamp_ns) / NS_PER_S / SLIP_S
            turn_rad = np.deg2rad(SLIPPED_DEG) * share
            step = step @ SE2.from_xy_yaw(SLIPPED_M * share, 0.0, turn_rad).as_matrix4()
        T_now = T_now @ step
        scans.append(replace(scan, T_odom_sensor=T_now))
    return replace(drive, scans=scans, ended_ns=ended_ns)


def exchanged(made: Made) -> Faulty:
    """Return the recording with another building's floorplan for ``GAP_S``."""
    drive = made.whole(made.by_kiss)
    ended_ns = drive.began_ns + int(GAP_S * NS_PER_S)
    plans = [(drive.began_ns, made.other_plan), (ended_ns, made.recording.floorplan)]

    def on_scan(localizer: Localizer, stamp_ns: int) -> None:
        while plans and stamp_ns >= plans[0][0]:
            localizer.set_plan(plans.pop(0)[1])

    return replace(drive, ended_ns=ended_ns, on_scan=on_scan)


def carried_away(made: Made) -> Faulty:
    """Return the recording with a kidnapped robot."""
    scans, true_ns, lifted_ns = carried(made.by_kiss)
    return Faulty(scans, true_ns, lifted_ns, lifted_ns)


FAULTS: dict[str, Callable[[Made], Faulty]] = {
    'none': lambda made: made.whole(made.by_kiss),
    'none_wheels': lambda made: made.whole(made.by_wheels),
    'none_large': lambda made: made.whole(made.by_kiss),
    'gap': with_gap,
    'turned': turned,
    'shifted': shifted,
    'slipped': slipped,
    'exchanged': exchanged,
    'carried': carried_away,
}


def run(made: Made, faulty: Faulty, config: FpnetConfig) -> dict[str, Any]:
    """Return the results of one recording with one fault."""
    localizer = create_localizer(config)
    localizer.set_plan(made.recording.floorplan)

    def scans() -> Iterator[Scan]:
        for scan in faulty.scans:
            faulty.on_scan(localizer, scan.stamp_ns)
            yield scan

    replay = Replay(scans(), localizer, config.localizer.update_period_s, None)
    for _ in replay:
        pass
    result = replay.result()
    changes = [(o.stamp_ns, o.said) for o in result.outputs]
    return {
        **figures(made.recording, faulty, result.published),
        'claimed_ticks': sum(o.status is Status.LOCALIZED for o in result.outputs),
        'said': [
            f'{(stamp - faulty.ended_ns) / NS_PER_S:.1f} s: {said}'
            for stamp, said in changes
            if -2 * NS_PER_S < stamp - faulty.began_ns < 20 * NS_PER_S
        ],
        'tick_ms': float(np.median(result.tick_ms)),
        'add_scan_ms': float(np.median(result.add_scan_ms)),
    }


def figures(recording: Recording, faulty: Faulty, published: PlanarTrajectory) -> dict[str, Any]:
    """Return error statistics of the published poses."""
    stamps_ns = np.array([scan.stamp_ns for scan in faulty.scans])
    when = np.searchsorted(stamps_ns, published.stamps_ns)
    poses = PlanarTrajectory(faulty.true_ns[when], published.xy, published.yaw)
    truth = PlanarTrajectory.from_transforms(recording.stamps_ns, recording.truth())
    metres, radians = pose_errors(poses.mapped(recording.A_plan_building.inv()), truth)
    off = (metres > OFF_M) | (radians > OFF_RAD)
    wrong = (metres > WRONG_POSITION_M) | (radians > WRONG_YAW_RAD)
    at_s = published.stamps_ns / NS_PER_S
    path_m = lengths_along(truth.xy)
    first = int(np.searchsorted(truth.stamps_ns, poses.stamps_ns[0])) if len(poses) else None
    right_s = at_s[~off]
    since = stamps_ns >= published.stamps_ns[0] if len(poses) else np.zeros(0, dtype=bool)
    return {
        'poses': len(poses),
        'off': int(off.sum()),
        'longest_s': longest(at_s[off]),
        'wrong': int(wrong.sum()),
        'recovery_s': recovery(right_s, faulty.ended_ns / NS_PER_S),
        'first_m': None if first is None else float(path_m[min(first, len(path_m) - 1)]),
        'median_m': float(np.median(metres)) if len(poses) else None,
        'localized': len(poses) / max(int(since.sum()), 1),
        'before': bool((right_s < faulty.began_ns / NS_PER_S).any()),
    }


def longest(times_s: np.ndarray) -> float:
    """Return the longest uninterrupted time [s] of poses at ``times_s``, which are off."""
    runs = np.split(times_s, np.flatnonzero(np.diff(times_s) > TOGETHER_S) + 1)
    return max((float(np.ptp(each)) + 0.1 for each in runs if len(each)), default=0.0)


def recovery(right_s: np.ndarray, ended_s: float) -> float | None:
    """Return the time after the fault until poses stay right [s], or None if they never do."""
    after = right_s[right_s >= ended_s]
    for number, start in enumerate(after):
        stays = after[number:][after[number:] <= start + STAYS_S]
        if np.ptp(stays) > STAYS_S - TOGETHER_S and np.diff(stays).max() < TOGETHER_S:
            return float(start - ended_s)
    return None


def drive(
    number: int, seed: int, names: Iterable[str], config: FpnetConfig, work: Path | None
) -> dict[str, Any]:
    """Return the results of one recording with each fault."""
    family, sensor = FAMILIES[number % len(FAMILIES)], SENSORS[number % len(SENSORS)]
    made = functools.cache(functools.partial(Made, seed + number, family, sensor, work))
    found = {}
    for name in names:
        here = made(name in IN_LARGE)
        found[name] = run(here, FAULTS[name](here), config)
    return {'seed': seed + number, 'family': family, 'sensor': sensor, 'faults': found}


def sums(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the totals of all recordings with one fault."""
    recovered = [r['recovery_s'] for r in runs if r['recovery_s'] is not None]
    firsts = [r['first_m'] for r in runs if r['first_m'] is not None]
    return {
        'drives': len(runs),
        'before': sum(r['before'] for r in runs),
        'recovered': len(recovered),
        'recovery_s_median': float(np.median(recovered)) if recovered else None,
        'recovery_s_max': max(recovered, default=None),
        'off': sum(r['off'] for r in runs),
        'longest_s': max(r['longest_s'] for r in runs),
        'long_off': sum(r['longest_s'] > STAYS_S for r in runs),
        'wrong': sum(r['wrong'] for r in runs),
        'localized': float(np.mean([r['localized'] for r in runs])),
        'first_m': float(np.median(firsts)) if firsts else None,
        'median_m': float(np.median([r['median_m'] for r in runs if r['median_m'] is not None])),
    }


def main() -> None:
    """Print one line per recording and fault, and the totals."""
    parser = drives_parser(__doc__, drives=10, seed=9300)
    parser.add_argument('--only', default=','.join(FAULTS), metavar='FAULT,...')
    parser.add_argument('--workers', type=int, default=1)
    parser.add_argument('--first', type=int, default=0, help='number of the first recording')
    parser.add_argument('--work', type=Path, metavar='FOLDER')
    arguments = parser.parse_args()
    names, config = arguments.only.split(','), load(None, arguments.set)
    make = functools.partial(
        drive, seed=arguments.seed, names=names, config=config, work=arguments.work
    )
    numbers = range(arguments.first, arguments.first + arguments.drives)
    drives = []
    for number, done in each_done(make, numbers, arguments.workers):
        for name, found in done['faults'].items():
            brief = {key: value for key, value in found.items() if key != 'said'}
            print(json.dumps({'drive': number, 'fault': name} | brief), flush=True)
        drives.append(done)
    faults = {name: sums([each['faults'][name] for each in drives]) for name in names}
    finish('faults', arguments.json, {'drives': drives, 'faults': faults})


if __name__ == '__main__':
    main()
