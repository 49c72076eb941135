# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is written of a score is its value, rounded."""

from dataclasses import replace
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st
import pytest

from fpnet_lab.scores import Unit, Units

UNITS = [unit for unit in vars(Units).values() if isinstance(unit, Unit)]
VALUES = st.floats(-1e6, 1e6, allow_nan=False)


def read(text, unit):
    """Return the value that a text states."""
    return float(text.removesuffix(unit.symbol)) / unit.factor


@given(unit=st.sampled_from(UNITS), value=VALUES, digits=st.integers(0, 4), up=st.booleans())
def test_a_text_is_within_half_of_its_last_digit(unit, value, digits, up):
    unit = replace(unit.to(digits), halves_up=up)
    text = unit.text(value)
    assert text.endswith(unit.symbol)
    last = 10.0**-digits / unit.factor
    assert read(text, unit) == pytest.approx(value, abs=0.5 * last + 1e-9 * abs(value) + 1e-12)
    assert len(text.removesuffix(unit.symbol).partition('.')[2]) == digits


@given(unit=st.sampled_from(UNITS), values=st.lists(VALUES, min_size=2), up=st.booleans())
def test_more_is_never_written_as_less(unit, values, up):
    unit = replace(unit, halves_up=up)
    written = [read(unit.text(value), unit) for value in sorted(values)]
    assert all(low <= high for low, high in pairwise(written))


@given(whole=st.integers(-1000, 1000), digits=st.integers(0, 2))
def test_halves_go_up(whole, digits):
    # Of whole halves, quarters and eighths floats hold each half exactly.
    unit = Unit(digits=digits, halves_up=True)
    assert float(Unit(halves_up=True).text(whole + 0.5)) == whole + 1
    assert float(unit.text(whole)) == whole


@given(unit=st.sampled_from(UNITS), value=VALUES, digits=st.integers(0, 3))
def test_a_unit_is_written_once_in_the_title_or_in_the_cell(unit, value, digits):
    beside, above = unit.to(digits), unit.in_title(digits)
    assert above.text(value) + unit.symbol == beside.text(value)
    assert beside.title('error') == 'error'
    assert above.title('error') == f'error [{unit.symbol.strip()}]'
