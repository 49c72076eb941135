# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Pictures of a generated storey's segmentation: the default in several styles, and baselines.

Run: python benchmarks/segmentation_pictures.py --out docs/images/segmentation.png

The last row shows where the default fails.
"""

import argparse
from pathlib import Path

import numpy as np

from fpnet.viz.pictures import saved_figure
from fpnet.viz.segmentation import draw_grid, draw_segmentation
from fpnet_core.config import SegmentationConfig
from fpnet_core.segmentation import segment_floorplan
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.styles import STYLES
from fpnet_lab.sim.plans import generate_plan

# Drawing style and method of each picture, row by row.
PANELS = (
    (('clean', 'default'), ('furnished', 'default')),
    (('furnished', 'morphological'), ('furnished', 'distance')),
    (('sketch', 'default'), ('architect', 'default')),
)
RESOLUTION_M = 0.05
MAX_ROOMS = 16
DPI = 60


def main() -> None:
    """Draw and save the pictures."""
    parser = argparse.ArgumentParser(description='Draw rooms and doors found in drawings.')
    parser.add_argument('--seed', type=int, default=4)
    parser.add_argument('--out', type=Path, default=Path('out/segmentation.png'))
    arguments = parser.parse_args()
    plan = generate_plan(np.random.default_rng(arguments.seed), max_rooms=MAX_ROOMS)
    with saved_figure(arguments.out, (15.0, 10.0), DPI) as figure:
        for row, panels in zip(figure.subplots(len(PANELS), 2), PANELS, strict=True):
            for ax, (style, method) in zip(row, panels, strict=True):
                grid = render_plan(plan, RESOLUTION_M, style=STYLES[style])
                found = segment_floorplan(grid, SegmentationConfig(method=method))
                draw_grid(ax, grid)
                draw_segmentation(ax, found)
                counts = f'{len(found.rooms)} rooms, {len(found.doors)} doors'
                ax.set_title(f'{style} drawing, {method}: {counts}')


if __name__ == '__main__':
    main()
