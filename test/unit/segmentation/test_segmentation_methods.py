# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The selectable methods on one drawing, other resolutions of it, and grids that are no storey."""

import cv2
import numpy as np
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.errors import MapFormatError
from fpnet_core.segmentation import floorplan, segment_floorplan
from fpnet_core.types import FREE, OCCUPIED, GridMap

# Rooms (x0, y0, x1, y1) in units of 0.4 m; the first is the corridor. Doors are 0.8 m wide.
ROOMS = [(1, 11, 41, 15), (1, 1, 14, 10), (15, 1, 28, 10), (29, 1, 41, 10)]
DOORS = [(6, 10, 8, 11), (20, 10, 22, 11), (33, 10, 35, 11)]


def plan(resolution_m=0.1):
    cells = np.full((16, 42), OCCUPIED, dtype=np.int8)
    for x0, y0, x1, y1 in ROOMS + DOORS:
        cells[y0:y1, x0:x1] = FREE
    each = round(0.4 / resolution_m)
    return GridMap(np.kron(cells, np.ones((each, each), dtype=np.int8)), resolution_m)


@pytest.mark.parametrize('method', ['default', 'morphological'])
def test_clean_plan_is_cut_into_its_rooms_and_doors(method):
    segmentation = segment_floorplan(plan(), SegmentationConfig(method=method))
    assert len(segmentation.rooms) == len(ROOMS)
    assert len(segmentation.doors) == len(DOORS)
    areas = sorted(0.16 * (x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in ROOMS)
    assert sorted(room.area_m2 for room in segmentation.rooms) == pytest.approx(areas, rel=0.05)


def test_the_inside_of_walls_drawn_as_two_lines_is_no_room():
    grid = plan(0.05)
    walls = (grid.cells == OCCUPIED).astype(np.uint8)
    faces = walls - cv2.erode(walls, np.ones((3, 3), np.uint8))
    outlined = GridMap(np.where(faces, OCCUPIED, FREE).astype(np.int8), 0.05)
    segmentation = segment_floorplan(outlined, SegmentationConfig())
    assert len(segmentation.rooms) == len(ROOMS)
    assert len(segmentation.doors) == len(DOORS)


def test_rooms_of_a_fine_drawing_reach_up_to_its_own_walls():
    grid = plan(0.0125)  # four of its cells lie in one that rooms are cut on
    found = segment_floorplan(grid, SegmentationConfig())
    free = found.grid.cells == FREE
    assert found.labels.shape == grid.shape
    assert (found.labels[free] > 0).mean() > 0.99
    assert not (found.labels[~free] > 0).any()


@pytest.mark.parametrize('resolution_m', [0.0125, 0.02, 0.05, 0.1])
def test_resolution_changes_neither_rooms_nor_doors(resolution_m):
    segmentation = segment_floorplan(plan(resolution_m), SegmentationConfig())
    assert len(segmentation.rooms) == len(ROOMS)
    widths = [portal.width_m for portal in segmentation.portals]
    assert widths == pytest.approx([0.8] * len(DOORS), abs=0.15)


def test_a_grid_too_large_for_a_storey_is_refused(monkeypatch):
    monkeypatch.setattr(floorplan, '_MAX_CELLS', 10_000)
    with pytest.raises(MapFormatError, match=r'168 x 64 cells.*crop'):
        segment_floorplan(plan(), SegmentationConfig())


@pytest.mark.parametrize('method', ['morphological', 'distance'])
@pytest.mark.parametrize('value', [FREE, OCCUPIED])
def test_simple_methods_give_a_reason_for_nothing(method, value):
    empty = GridMap(np.full((30, 40), value, dtype=np.int8), 0.05)
    segmentation = segment_floorplan(empty, SegmentationConfig(method=method))
    assert segmentation.regions == ()
    assert segmentation.reason
