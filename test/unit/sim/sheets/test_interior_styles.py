# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What varied sheets show within their buildings, and the truth about it."""

from dataclasses import replace

import numpy as np
import pytest

from fpnet_core.io.pixel_classes import DOOR, FLOOR, WALL
from fpnet_core.raster.pixels import shrinking
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.sheets import draw_sheet, looks
from fpnet_lab.sim.sheets.classes import SYMBOL_BIT, TEXT_BIT, sheet_classes, sheet_overlays
from fpnet_lab.sim.sheets.interior_style import draw_interior_style
from fpnet_lab.sim.sheets.lengths_written import area_text, length_text, size_text

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


def test_light_lines_between_filled_rooms_are_walls(monkeypatch, plan):
    def separated(rng):
        style = draw_interior_style(rng)
        return replace(
            style,
            separator=(1.0, 1.0, 1.0),
            glass_share=0.0,
            floors=(),
            tags=None,
            room_symbols=(),
            storey_symbols=(),
        )

    monkeypatch.setattr(looks, 'draw_interior_style', separated)
    sheet = next(
        found
        for seed in range(20)
        if (found := draw_sheet(seed, 'varied', plan)).medium is None
        and not found.look.traits & {looks.Trait.INVERTED, looks.Trait.TRANSPARENT}
        and found.look.interior.outer.kind == 'solid'
        and max(found.pixels.shape) > 1000
    )
    classes, grey = sheet_classes(sheet), sheet.pixels[..., :3].mean(axis=2)
    is_light = (classes == WALL) & (grey > 250.0)
    assert is_light.sum() > 200
    assert np.median(grey[classes == FLOOR]) < 240.0
    assert np.median(grey[classes == DOOR]) < 250.0


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


def test_lengths_and_areas_are_true():
    assert length_text(3.81, 4) == '12\'-6"'
    assert length_text(3.25, 3) == '325'
    assert size_text(3.25, 2.85, 3) == '325 x 285'
    assert area_text(13.2, 4) == '142 sq ft'
    assert area_text(13.2, 3) == 'NGF 13,2'
