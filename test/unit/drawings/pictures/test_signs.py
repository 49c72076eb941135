# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What stands among walls in another colour is a sign."""

import numpy as np
import pytest

from fpnet_core.drawings.pictures.signs import coloured_signs

GREEN, BLACK, GREY = (10, 125, 50), (0, 0, 0), (150, 150, 150)


def plan(wall, piece, at=(40, 60)):
    """Four walls of one colour and a piece within of another: walls, and the picture."""
    picture = np.full((100, 160, 3), 255, np.uint8)
    for window in (np.s_[10:16, 10:150], np.s_[84:90, 10:150], np.s_[10:90, 10:16],
                   np.s_[10:90, 144:150]):  # fmt: skip
        picture[window] = wall
    own = np.zeros(picture.shape[:2], np.bool_)
    own[at[0] : at[0] + 6, at[1] : at[1] + 30] = True
    picture[own] = piece
    return (picture < 255).any(axis=2), picture, own


@pytest.mark.parametrize('wall', [BLACK, GREY, (180, 60, 40)])
def test_an_arrow_of_another_colour_is_one(wall):
    walls, picture, own = plan(wall, GREEN)
    assert (coloured_signs(walls, picture) == own).all()


@pytest.mark.parametrize(('wall', 'piece'), [(GREY, BLACK), (BLACK, GREY), (GREEN, GREEN)])
def test_a_column_of_another_tone_is_none(wall, piece):
    walls, picture, _ = plan(wall, piece)
    assert not coloured_signs(walls, picture).any()


def test_what_goes_on_from_a_wall_is_none():
    walls, picture, _ = plan(BLACK, GREEN, at=(40, 16))
    assert not coloured_signs(walls, picture).any()


def test_no_walls_have_no_signs():
    nothing = np.zeros((20, 30), np.bool_)
    assert not coloured_signs(nothing, np.full((20, 30, 3), 255, np.uint8)).any()
