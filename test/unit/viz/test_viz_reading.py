# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The picture of a reading has the numbers that messages use."""

from matplotlib.figure import Figure
import numpy as np
from planted import plan_grid
import pytest

from fpnet.viz.reading import draw_reading
from fpnet.viz.segmentation import label_xy
from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.types import Drawing, DrawingScale, Reading, ScaleSource
from fpnet_core.raster.pixels import map_points, pixel_to_xy
from fpnet_core.segmentation import segment_floorplan


@pytest.mark.parametrize('full_size', [None, (1800, 1600)])
def test_rooms_and_doors_have_their_numbers(full_size):
    grid = plan_grid()
    height, width = grid.shape
    step = 1.0 if full_size is None else full_size[0] / width
    drawing = Drawing(
        np.full((height, width, 3), 255, np.uint8),
        'a.png',
        'png',
        full_size=None if full_size is None else (full_size[0], round(step * height)),
    )
    H = pixel_to_xy(grid).matrix @ np.diag([1.0 / step, 1.0 / step, 1.0])
    stated = DrawingScale(0.05, 0.05, 0.05, ScaleSource.STATED)
    rooms = segment_floorplan(grid, FpnetConfig().segmentation)
    ax = Figure().add_subplot()
    draw_reading(ax, Reading(grid, stated, H, 'as drawn', drawing, cut=rooms))
    written = {text.get_text(): text.xy for text in ax.texts}
    numbers = {str(room.id) for room in rooms.rooms} | {str(p.door) for p in rooms.portals}
    assert numbers <= written.keys()
    assert len(numbers) == 7 + 6
    room = rooms.rooms[3]
    place = map_points(np.linalg.inv(H), np.array([label_xy(room)]))[0]
    np.testing.assert_allclose(written[str(room.id)], place)
    assert ax.get_xlim() == (-0.5, drawing.size[0] - 0.5)
    left, right, bottom, top = ax.images[0].get_extent()
    assert (left, top) == (-0.5, -0.5)
    assert (right, bottom) == (drawing.size[0] - 0.5, drawing.size[1] - 0.5)
