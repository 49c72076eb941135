# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scores of known overlaps, and drawings on an Axes."""

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
import numpy as np
import pytest

from fpnet.viz.segmentation import draw_grid, draw_segmentation, region_colour
from fpnet_core.config import SegmentationConfig
from fpnet_core.geometry import SE2
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.types import FREE, OCCUPIED, GridMap
from fpnet_lab.metrics.openings import true_openings


def halves(cut):
    """Labels 1 and 2 left and right of column ``cut`` in 40 x 100 cells."""
    labels = np.ones((40, 100), dtype=np.int32)
    labels[:, cut:] = 2
    return labels


def test_equal_labels_agree_fully_whatever_their_numbers():
    agreement = room_agreement(3 - halves(30), halves(30))
    assert (agreement.precision, agreement.recall, agreement.f1) == (1.0, 1.0, 1.0)


def test_shifted_border_costs_its_share():
    agreement = room_agreement(halves(40), halves(50))
    assert agreement.precision == pytest.approx((1.0 + 50 / 60) / 2)
    assert agreement.recall == pytest.approx((40 / 50 + 1.0) / 2)
    assert agreement.f1 == 1.0


def test_merged_rooms_keep_recall_and_lose_f1():
    agreement = room_agreement(np.ones((40, 100), dtype=np.int32), halves(50))
    assert (agreement.precision, agreement.recall, agreement.f1) == (0.5, 1.0, 0.0)


def test_opening_lies_where_two_labels_meet():
    truth = halves(50)
    truth[:, 46:54] = 0
    free = np.ones(truth.shape, dtype=bool)
    free[:, 46:54] = False
    free[5:25, 46:54] = True
    (place,) = true_openings(truth, free)
    assert place == pytest.approx([14.5, 49.5], abs=1.0)


def test_drawing_covers_the_rotated_grid_and_keeps_colours():
    cells = np.full((60, 90), OCCUPIED)
    cells[5:55, 5:85] = FREE
    grid = GridMap(cells, 0.1, SE2.from_xy_yaw(2.0, -1.0, 0.6))
    segmentation = segment_floorplan(grid, SegmentationConfig())
    ax = Figure().add_subplot()
    draw_grid(ax, grid)
    draw_segmentation(ax, segmentation, {0: (1.0, 0.0, 0.0)}, with_ids=True)
    FigureCanvasAgg(ax.figure).draw()
    corners = grid.rc_to_xy([[-0.5, -0.5], [-0.5, 89.5], [59.5, 89.5], [59.5, -0.5]])
    low, high = np.array([ax.get_xlim(), ax.get_ylim()]).T
    margins_m = corners.min(axis=0) - low, high - corners.max(axis=0)
    assert ((np.array(margins_m) >= 0.0) & (np.array(margins_m) < 0.6)).all()
    tint = ax.images[1].get_array()
    assert tuple(tint[30, 45][:3]) == (1.0, 0.0, 0.0)
    assert tint[0, 0][3] == 0.0
    assert [text.get_text() for text in ax.texts] == ['0']
    assert len({region_colour(k) for k in range(40)}) == 40
