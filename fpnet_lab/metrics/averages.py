# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Averages that return None for no values; :mod:`fpnet.accuracy` has the quantile."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np


def mean(values: Iterable[float]) -> float | None:
    """Return the mean; None for no values."""
    each = list(values)
    return float(np.mean(each)) if each else None


def share(flags: Iterable[bool]) -> float | None:
    """Return the share of True; None for no values."""
    return mean(flags)
