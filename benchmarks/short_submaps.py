# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Localization from short submaps: a single scan, or a path of 15 or 30 m.

Run: python benchmarks/short_submaps.py [--buildings 28] [--seed 5000] [--json OUT]

Generated, furnished buildings of every kind except symmetric ones and those of identical rooms,
with redrawn drawings stretched by up to 4 % in x and y, sensors in turn, true odometry. Three
pieces of each recording are matched with the correct drawing and with that of the previous
building, in a single update like ``fpnet match``: without a position prior, with a stated scale. A
placement is right within 5 degrees, 10 % of scale and 3 % of the drawing's diagonal. Times are CPU
times, without the segmentation of the plan.
"""

from dataclasses import asdict, dataclass
from functools import lru_cache
import time

import numpy as np

from fpnet.cli.progress import progress
from fpnet_core.config import FpnetConfig
from fpnet_core.localizer import MapMatchStatus
from fpnet_core.localizer.global_localizer import GlobalLocalizer
from fpnet_core.localizer.maps import match_segmented, segment_plan, segment_robot_map
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.scoring import PlacementScorer
from fpnet_core.submaps import SubmapBuilder
from fpnet_core.trajectory import lengths_along
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.evaluation.localization.cases import PLAIN_FAMILIES, SENSOR_CYCLE
from fpnet_lab.kept import make_once
from fpnet_lab.metrics import placement_error
from fpnet_lab.sim.drives.recording import RecordingOptions, make_recording
from fpnet_lab.sim.lidars.sensors import SENSORS

PATHS_M = {'one scan': 0.0, '15 m': 15.0, '30 m': 30.0}
PIECES, EVERY = 3, 3


@dataclass(frozen=True)
class DrivenBuilding:
    """A building, given by its number and the common seed."""

    number: int
    seed: int

    @property
    def name(self):
        """Name of the results' file."""
        return f'{self.seed}_{self.number:03d}'


@dataclass(frozen=True)
class DrivePiece:
    """A piece of a recording: observed area, and the match results on both drawings."""

    building: int
    path: str
    sensor: str
    seen_m2: float
    is_right: bool
    is_accepted: bool
    is_foreign_claimed: bool
    seconds: float


@lru_cache(maxsize=3)
def drive_of(number, seed):
    """Return the recording in a building."""
    options = RecordingOptions(
        family=PLAIN_FAMILIES[number % len(PLAIN_FAMILIES)],
        lidar=SENSORS[SENSOR_CYCLE[number % len(SENSOR_CYCLE)]],
    )
    return make_recording(seed + number, options, 1)


def submap_of(recording, first, last):
    """Return the submap of scans ``first`` to ``last``, in the building's frame."""
    builder = SubmapBuilder(FpnetConfig().submap)
    for index in range(first, last + 1, EVERY):
        scan = recording.deskewed(index)
        builder.add_scan(scan.points, scan.T_odom_sensor, scan.stamp_ns)
    return builder.take()


def pieces_of(recording, path_m):
    """Return the first and last scan indices of evenly spaced pieces of a recording."""
    along = lengths_along(recording.truth()[:, :2, 3])
    starts = np.linspace(0.0, max(0.0, along[-1] - path_m), PIECES)
    first = np.minimum(np.searchsorted(along, starts), len(along) - 1)
    last = np.minimum(np.searchsorted(along, starts + path_m), len(along) - 1)
    return list(zip(first.tolist(), last.tolist(), strict=True))


def run_building(building):
    """Return the results of all pieces of the recording in one building."""
    config = FpnetConfig()
    matcher = LearnedMatcher(config.matcher)
    global_localizer = GlobalLocalizer(
        matcher, PlacementScorer.configured(config.localizer), config
    )
    recording = drive_of(building.number, building.seed)
    other = drive_of(building.number - 1 if building.number else 1, building.seed)
    own, foreign = (segment_plan(each.floorplan, config, True) for each in (recording, other))
    diagonal_m = float(np.hypot(*recording.floorplan.shape)) * recording.floorplan.resolution
    found = []
    for path, path_m in PATHS_M.items():
        for first, last in pieces_of(recording, path_m):
            submap = submap_of(recording, first, last if path_m else first)
            begun = time.process_time()
            cut = segment_robot_map(submap, config, True)
            match = match_segmented(own, cut, global_localizer, StageTimer())
            seconds = time.process_time() - begun
            truth = recording.A_plan_building @ submap.T_odom_submap
            middle = tuple(submap.grid.rc_to_xy(np.argwhere(submap.grid.cells == 0).mean(axis=0)))
            error = placement_error(match.A_best, truth, middle)
            elsewhere = match_segmented(foreign, cut, global_localizer, StageTimer())
            found.append(
                DrivePiece(
                    building.number,
                    path,
                    SENSOR_CYCLE[building.number % len(SENSOR_CYCLE)],
                    submap.free_area_m2,
                    error.is_right(diagonal_m),
                    match.status is MapMatchStatus.MATCHED,
                    elsewhere.status is MapMatchStatus.MATCHED,
                    seconds,
                )
            )
    return tuple(found)


def summary(pieces):
    """Return the totals of pieces of one length."""
    return {
        'pieces': len(pieces),
        'seen_m2': float(np.median([piece.seen_m2 for piece in pieces])),
        'right': float(np.mean([piece.is_right for piece in pieces])),
        'claimed_right': float(np.mean([p.is_right and p.is_accepted for p in pieces])),
        'wrong': sum(piece.is_accepted and not piece.is_right for piece in pieces),
        'foreign': sum(piece.is_foreign_claimed for piece in pieces),
        'seconds': float(np.median([piece.seconds for piece in pieces])),
    }


def main() -> None:
    """Print how often pieces of each length are placed correctly and accepted."""
    parser = script_parser(__doc__)
    parser.add_argument('--buildings', type=int, default=28)
    parser.add_argument('--seed', type=int, default=5000)
    parser.add_argument('--workers', type=int, default=1)
    arguments = parser.parse_args()
    buildings = [DrivenBuilding(number, arguments.seed) for number in range(arguments.buildings)]
    with progress('buildings', len(buildings)) as advance:
        named = {building.name: building for building in buildings}
        results = make_once(
            None, DrivePiece, named, run_building, arguments.workers, on_done=advance
        )
    pieces = [piece for each in results for piece in each]
    paths = {path: summary([p for p in pieces if p.path == path]) for path in PATHS_M}
    finish('short_submaps', arguments.json, {'paths': paths, 'pieces': list(map(asdict, pieces))})


if __name__ == '__main__':
    main()
