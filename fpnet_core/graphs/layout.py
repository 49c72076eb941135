# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Meaning of the columns of node rows, for code that changes rows without recomputing them."""

from __future__ import annotations

from dataclasses import dataclass

POSITION = slice(0, 2)
"""Columns of the region's centre, in every layout."""


@dataclass(frozen=True)
class FeatureLayout:
    """
    Columns of one kind of node row.

    Parameters
    ----------
    size : number of columns
    odd : columns that change their sign when the map is mirrored at the y axis
    log_lengths : columns that grow by 1 when all lengths grow by the factor e
    noisy : columns of shapes and sizes, to which training adds noise
    axis : columns with the doubled angle of the region's axis, which rotate with the map
    """

    size: int
    odd: tuple[int, ...]
    log_lengths: tuple[int, ...]
    noisy: slice
    axis: slice | None = None
