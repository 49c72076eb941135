# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Constants that decide are found among many that are changed together."""

import importlib
from pathlib import Path

import pytest

from fpnet_core.config import FpnetConfig

BENCHMARKS = Path(__file__).resolve().parents[3] / 'benchmarks'
NAMES = ('A', 'B', 'C', 'D', 'E')


@pytest.fixture
def vary(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module('vary_constants')


def trials(vary, decides):
    """Constants of which some decide: by name, whether larger or smaller; and all trials."""
    every = [vary.Varied('m', name, frozenset({('m', name)})) for name in NAMES]

    class Planted(vary.Trials):
        def other_answer(self, factors):
            self.count += 1
            by_name = {each.name: by > 1.0 for each, by in factors.items()}
            return 'other' if decides(by_name) else ''

    found = Planted([], FpnetConfig(), 1.2)
    found.ups = dict.fromkeys(every, True)
    return every, found


def names(found):
    return [each.name for each, _ in found]


def test_what_decides_is_found_in_the_direction_that_decides(vary):
    every, tried = trials(vary, lambda up: up.get('B') is True or up.get('D') is False)
    assert names(tried.deciding(every, is_turned=False)) == ['B']
    assert names(tried.deciding(every, is_turned=True)) == ['D']


@pytest.mark.parametrize(
    ('value', 'by', 'expected'),
    [
        (3, 1.2, 4), (1, 0.8, 0), (0, 0.8, 0), (2.0, 4.0, 8.0),
        ((1, 'a', True), 4.0, (4, 'a', True)),
    ],
)  # fmt: skip
def test_whole_numbers_move_by_one_at_least(vary, value, by, expected):
    assert vary.scaled(value, by) == expected


def test_a_constant_is_changed_wherever_it_was_imported_to(vary):
    homes = vary._homes(('fpnet_core.pose.verify', 'WALL_SIGMA_M'), vary.imported())
    assert {module for module, _ in homes} == {
        'fpnet_core.pose.verify',
        'fpnet_core.pose.estimate',
    }
