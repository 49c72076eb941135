# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Sources of IoU loss of segmented submap rooms, by sensor.

Run: python benchmarks/submap_losses.py [--drives 25] [--first-seed 0] [--sensor planar]
     [--json OUT]; then fpnet bench figures submap_losses=OUT

The recordings are those of ``fpnet bench segmentation``, with one sensor or each in turn. Every
sufficiently observed room is scored three times: segmented by the product (``shipped``), with
every candidate line decided by ground truth (``decided``), and with all segmented space assigned
to the nearest true room (``cut``). The loss between the second and the third is due to missing
candidate lines. The remaining loss of ``cut`` is reported in shares of the room's observed part:
unassigned ``returns``, ``unseen`` and ``free`` cells inside it, with those less than 0.15 m from
its outline as ``rim``; and ``beyond``, the room's cells outside of it.
"""

from collections.abc import Iterator
from functools import partial

import numpy as np
from scipy.ndimage import distance_transform_edt

from fpnet_core.config import FpnetConfig
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.segmentation.assemble import upsample_labels
from fpnet_core.segmentation.submap import is_from_scans, segment_part
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.evaluation.localization.drives import submap_of
from fpnet_lab.evaluation.submap_recordings import SENSOR_NAMES, registered_drive
from fpnet_lab.evaluation.submap_segmentation import (
    drawn_rooms,
    observed_truth,
    pair_rooms,
    true_rooms,
)

RIM_M = 0.15
KINDS = {'returns': OCCUPIED, 'unseen': UNKNOWN, 'free': FREE}
COLUMNS = (
    'shipped', 'decided', 'cut',
    *(f'{kind}{where}' for kind in KINDS for where in (' rim', '')), 'beyond',
)  # fmt: skip


def decided(truth, parts):
    """Return the piece that each piece is merged into according to ``truth (H, W)``."""
    passable = parts.scene.free & ~parts.scene.lintel
    labels = upsample_labels(parts.labels, parts.work.stride, passable)
    overlap = np.zeros((len(parts.pieces.peak), int(truth.max()) + 1))
    np.add.at(overlap, (labels, truth), 1.0)
    overlap[:, 0] = 0.0
    room, target = overlap.argmax(axis=1), np.arange(len(overlap))
    for a, b in parts.lines.pieces.tolist():
        if room[a] == room[b] > 0:
            target[target == target[b]] = target[a]
    return target


def losses(drive, submap) -> Iterator[list[float]]:
    """Yield a row of :data:`COLUMNS` for every sufficiently observed room."""
    grid, has_scans = submap.grid, is_from_scans(submap)
    whole = drawn_rooms(true_rooms(drive.plan), drive.T_building_odom.inv(), grid)
    shipped, ideal = (
        segment_part(grid, submap.lintel, has_scans=has_scans, **more)
        for more in ({}, {'decide': partial(decided, whole)})
    )
    truth, usable = observed_truth(shipped, drive)
    row, col = distance_transform_edt(whole == 0, return_distances=False, return_indices=True)
    found = (shipped.labels > 0) | (ideal.labels > 0)
    cut = np.where(found, whole[row, col], 0).astype(np.int32)
    scores = [
        [iou for _, iou in pair_rooms(truth, labels, usable)]
        for labels in (shipped.labels, ideal.labels, cut)
    ]
    for label, *ious in zip(usable, *scores, strict=True):
        room = truth == label
        is_rim = cells_to_nearest(whole != label) * grid.resolution <= RIM_M
        lost = [
            room & ~found & (grid.cells == value) & where
            for value in KINDS.values()
            for where in (is_rim, ~is_rim)
        ]
        cells = [np.count_nonzero(mask) for mask in (*lost, (cut == label) & ~room)]
        yield [*ious, *(count / np.count_nonzero(room) for count in cells)]


def main() -> None:
    """Segment all recordings and print a table."""
    parser = script_parser(__doc__)
    parser.add_argument('--drives', type=int, default=25)
    parser.add_argument('--first-seed', type=int, default=0)
    parser.add_argument('--sensor', choices=SENSOR_NAMES)
    arguments = parser.parse_args()
    names = SENSOR_NAMES if arguments.sensor is None else (arguments.sensor,)
    config, rows = FpnetConfig(), {name: [] for name in names}
    for number in range(arguments.drives):
        name = names[number % len(names)]
        drive = registered_drive(arguments.first_seed + number, name, config)
        rows[name] += losses(drive, submap_of(drive.sweeps, config.submap))
    rows['all'] = [row for some in rows.values() for row in some]
    sensors = {name: _means(some) for name, some in rows.items() if some}
    finish('submap_losses', arguments.json, {'sensors': sensors})


def _means(rows):
    """Return the number of a sensor's rooms, and their mean values."""
    means = np.mean(rows, axis=0).tolist()
    return {'rooms': len(rows)} | dict(zip(COLUMNS, means, strict=True))


if __name__ == '__main__':
    main()
