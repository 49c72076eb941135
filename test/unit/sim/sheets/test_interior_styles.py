# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What varied sheets show within their buildings, and the truth about it."""

import numpy as np
import pytest

from fpnet_core.raster.pixels import shrinking
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.sheets import draw_sheet
from fpnet_lab.sim.sheets.classes import SYMBOL_BIT, TEXT_BIT, sheet_classes, sheet_overlays

_SEEDS = (5, 10)


@pytest.fixture(scope='module')
def plan():
    return generate_plan(np.random.default_rng(3), max_rooms=25, max_area_m2=900.0)


@pytest.mark.parametrize('seed', _SEEDS)
def test_equal_seeds_give_equal_sheets(seed, plan):
    a, b = (draw_sheet(seed, 'varied', plan) for _ in range(2))
    np.testing.assert_array_equal(a.pixels, b.pixels)
    np.testing.assert_array_equal(sheet_classes(a), sheet_classes(b))
    np.testing.assert_array_equal(sheet_overlays(a), sheet_overlays(b))


def test_overlays_have_letters_and_symbols(plan):
    bits = 0
    for seed in _SEEDS:
        sheet = draw_sheet(seed, 'varied', plan)
        rows, cols = sheet.pixels.shape[0] // 2, sheet.pixels.shape[1] // 2
        overlays = sheet_overlays(sheet, shrinking(0.5), (rows, cols))
        assert overlays.shape == (rows, cols)
        assert set(np.unique(overlays)) <= {0, TEXT_BIT, SYMBOL_BIT, TEXT_BIT | SYMBOL_BIT}
        bits |= int(np.bitwise_or.reduce(overlays, axis=None))
    assert bits == TEXT_BIT | SYMBOL_BIT
