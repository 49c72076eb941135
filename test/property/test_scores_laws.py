# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is written of a score is its value, rounded."""

from dataclasses import replace

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
