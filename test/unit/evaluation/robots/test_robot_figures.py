# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Figures of planted outcomes, to the last digit."""

import pytest

from fpnet_lab.evaluation.robots.robot_figures import Foreign, Outcome, robot_figures

SAME_CLAIMED, SAME_NOT = Foreign(True, True), Foreign(True, False)
OTHER_CLAIMED, OTHER_NOT = Foreign(False, True), Foreign(False, False)


def outcome(right, claimed, *foreign, band='20-35', building='a', distorted=False):
    return Outcome(band, building, distorted, right, claimed, foreign)


@pytest.fixture
def outcomes():
    return [
        outcome(True, True, OTHER_NOT, OTHER_NOT, SAME_CLAIMED),
        outcome(True, False, OTHER_CLAIMED, OTHER_NOT, SAME_NOT),
        outcome(False, True, OTHER_NOT, OTHER_NOT),
        outcome(False, False, building='b', distorted=True),
        outcome(False, True, OTHER_CLAIMED, building='b', distorted=True),
        outcome(True, True, band='whole', building='b', distorted=True),
    ]


def test_shares_are_of_all_pairs_and_of_all_foreign_pairs(outcomes):
    assert robot_figures(outcomes)['bands']['20-35'] == {
        'right': 2 / 5,
        'claimed_right': 1 / 5,
        'wrong_and_claimed': 2 / 5,
        'foreign_claimed': 3 / 9,
        'foreign_random_claimed': 2 / 7,
        'foreign_same_architect_claimed': 1 / 2,
        'pairs': 5,
        'foreign_pairs': 9,
        'foreign_same_architect_pairs': 2,
    }


def test_distorted_drawings_are_left_out_of_one_summary_only(outcomes):
    figures = robot_figures(outcomes)
    left = figures['bands_undistorted']
    assert (left['20-35']['pairs'], left['20-35']['foreign_pairs']) == (3, 8)
    assert left['20-35']['right'] == 2 / 3
    assert left['20-35']['wrong_and_claimed'] == 1 / 3
    assert left['20-35']['foreign_random_claimed'] == 1 / 6
    assert (figures['bands']['whole']['pairs'], left['whole']['pairs']) == (1, 0)
