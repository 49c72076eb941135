# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Components drawn around the building of a varied sheet, and what happens to its picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class SurroundStyle:
    """Which components a sheet shows around its building."""


def draw_surround_style(rng: np.random.Generator) -> SurroundStyle:
    """Draw a combination of components."""
    del rng
    return SurroundStyle()
