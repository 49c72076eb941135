# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pieces of free space joined into rooms."""

import numpy as np

from fpnet_core.segmentation.door_figures import LINE_FIGURES
from fpnet_core.segmentation.door_model import FIGURES, MAP_FIGURES
from fpnet_core.segmentation.joining import (
    DividingLines,
    Pieces,
    absorb_small,
    join_pieces,
    joining_stages,
)

CELL_M = 0.1


def row_of_rooms(widths):
    """Pieces of 20 rows each, side by side, of so many columns; a clearance that grows."""
    labels = np.repeat(np.arange(1, len(widths) + 1), widths)[None].repeat(20, axis=0)
    labels = np.pad(labels, 1).astype(np.int32)
    frontier = np.zeros(labels.shape, np.bool_)
    frontier[1:-1, -2] = True
    return Pieces.of(labels, labels.astype(np.float32), frontier, CELL_M)


def lines_between(pairs, widths):
    count = len(LINE_FIGURES) + len(MAP_FIGURES)
    return DividingLines(np.array(pairs), np.array(widths), np.zeros((len(pairs), count)))


def by_width(least):
    """Judge that wide lines part nothing, the wider the surer."""
    column = FIGURES.index('over_wide')
    return lambda figures: np.clip(figures[:, column] - least + 0.5, 0.0, 1.0)


def test_the_surest_join_first_and_the_others_are_judged_again():
    pieces = row_of_rooms([10, 10, 30])
    lines = lines_between([(1, 2), (2, 3)], [1.0, 0.7])
    # Over the width of a piece of one metre both lines are wide; the second is not any more when
    # the first two pieces are one that is two metres wide.
    stages = list(joining_stages(pieces, lines, by_width(0.6)))
    assert [stage.tolist() for stage in stages] == [[0, 1, 1, 3]]
    np.testing.assert_array_equal(join_pieces(pieces, lines, by_width(0.6)), stages[-1])


def test_nothing_joins_across_no_lines_or_doors():
    pieces, lines = row_of_rooms([10, 30]), lines_between([(1, 2)], [0.1])
    np.testing.assert_array_equal(join_pieces(pieces, lines, by_width(0.6)), [0, 1, 2])
    none = DividingLines(
        np.zeros((0, 2), np.int64), np.zeros(0), np.zeros((0, lines.figures.shape[1]))
    )
    np.testing.assert_array_equal(join_pieces(pieces, none, by_width(0.6)), [0, 1, 2])


def test_small_pieces_join_across_their_widest_line_unless_they_are_glimpsed():
    pieces = row_of_rooms([30, 5, 30, 5])
    lines = lines_between([(1, 2), (2, 3), (3, 4)], [0.5, 0.9, 0.9])
    start = np.arange(5)
    target = absorb_small(pieces, lines, start, 1.5, frontier_m=0.8)
    assert target[2] == target[3] != target[1]
    assert target[4] == 4  # the last one's edge to unseen space is two metres long
    assert (absorb_small(pieces, lines, start, 1.5, frontier_m=3.0)[4] == target[3]).all()
