# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Pictures of true rooms and segmented submaps side by side, with matched rooms in one colour.

Run: python benchmarks/submap_pictures.py beams32:101 beams16:104 --out PNG

Each argument is a sensor model and the seed of a building. Rooms that are not sufficiently
observed stay white; segmented rooms without a match are brown.
"""

import argparse
from pathlib import Path

from matplotlib.patches import Polygon
import numpy as np
import shapely

from fpnet.viz.pictures import saved_figure
from fpnet.viz.segmentation import draw_grid, draw_segmentation, region_colour
from fpnet_core.config import FpnetConfig
from fpnet_lab.evaluation.submap_recordings import RegisteredDrive, registered_drive
from fpnet_lab.evaluation.submap_segmentation import (
    paired_rooms,
    score_segmentation,
    segment_drive,
    true_rooms,
)

BROWN = (0.55, 0.35, 0.15)
TINT = 0.55
DPI = 55


def draw_drive(axes, drive: RegisteredDrive, segmentation, title: str) -> None:
    """Draw the building on the left and the submap on the right, both in ``odom``."""
    pairs = paired_rooms(segmentation, drive)
    T_odom_building = drive.T_building_odom.inv()
    left, right = axes
    for index, room in enumerate(true_rooms(drive.plan)):
        colour = region_colour(index) if index in pairs else (1.0, 1.0, 1.0)
        for part in shapely.get_parts(room).tolist():
            outline = T_odom_building.apply(shapely.get_coordinates(part.exterior))
            left.add_patch(Polygon(outline, facecolor=(*colour, TINT), edgecolor='black'))
    for door in drive.plan.doors:
        if not door.is_open:
            left.plot(*T_odom_building.apply(door.ends).T, color='red', linewidth=2.0)
    draw_grid(right, segmentation.grid)
    colours = {room.id: BROWN for room in segmentation.rooms}
    colours |= {found: region_colour(index) for index, found in pairs.items()}
    draw_segmentation(right, segmentation, colours)
    left.set(xlim=right.get_xlim(), ylim=right.get_ylim(), aspect='equal', title=title)
    left.set(xlabel='x in odom [m]', ylabel='y in odom [m]')


def main() -> None:
    """Draw and save the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('drives', nargs='+', metavar='SENSOR:SEED')
    parser.add_argument('--out', type=Path, default=Path('out/submaps.png'))
    arguments = parser.parse_args()
    config = FpnetConfig()
    size = (16.0, 7.0 * len(arguments.drives))
    with saved_figure(arguments.out, size, DPI) as figure:
        rows = figure.subplots(len(arguments.drives), 2, squeeze=False)
        for axes, name in zip(rows, arguments.drives, strict=True):
            sensor, seed = name.split(':')
            drive = registered_drive(int(seed), sensor, config)
            segmentation = segment_drive(drive, config)
            score = score_segmentation(segmentation, drive, sensor, int(seed))
            title = f'{sensor}, building {seed}: mean IoU {np.mean(score.room_ious):.2f}'
            draw_drive(axes, drive, segmentation, title)


if __name__ == '__main__':
    main()
