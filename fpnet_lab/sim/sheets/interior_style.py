# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Components drawn within the building of a varied sheet, each chosen on its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class InteriorStyle:
    """Which components a sheet shows within its building."""


def draw_interior_style(rng: np.random.Generator) -> InteriorStyle:
    """Draw a combination of components."""
    del rng
    return InteriorStyle()
