# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Hatches are many even lines; walls, stairs and rows of cells are not."""

import numpy as np
import pytest

from fpnet_core.drawings.formats.hatching import find_hatching
from fpnet_core.drawings.formats.pages import BLACK, PageBuilder, Paint, Ring, outline_pieces

SIZE = 60.0


def lines_at(offsets, angle, length=9.0):
    along = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-along[1], along[0]])
    return [np.array([across * offset, across * offset + along * length]) for offset in offsets]


def found(lines, style=None):
    builder = PageBuilder('test')
    for line in lines:
        builder.add([Ring(line)], Paint(stroke=BLACK))
    style = np.zeros(len(lines), int) if style is None else np.asarray(style)
    return find_hatching(outline_pieces(builder.finish()), style, SIZE)


@pytest.mark.parametrize('angle', [0.0, 0.7, 2.4, 3.14])
def test_even_lines_are_a_hatch(angle):
    evenly = lines_at(np.arange(40) * 0.3, angle)
    beside = lines_at(np.arange(30) * 0.3 + 60.0, angle, 2.0)
    assert found(evenly + beside).all()


def test_lines_of_another_style_stay():
    lines = lines_at(np.arange(40) * 0.3, 0.7) + lines_at([3.05, 7.0], 0.7)
    assert found(lines, [0] * 40 + [1] * 2).tolist() == [True] * 40 + [False] * 2


@pytest.mark.parametrize('offsets', [
    np.arange(14) * 0.28,  # a flight of stairs
    np.arange(30) * 2.5,  # cells of a corridor, walls as single lines
    np.concatenate([np.arange(20) * 2.5, np.arange(20) * 2.5 + 0.2]),  # the same with two faces
    np.cumsum(np.random.default_rng(4).uniform(0.05, 0.8, 50)),
])  # fmt: skip
def test_other_parallel_lines_stay(offsets):
    assert not found(lines_at(offsets, 0.7)).any()
