# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Averages of what there may be nothing of; ``fpnet.accuracy`` has the quantile."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np


def mean(values: Iterable[float]) -> float | None:
    """Return the mean, None of nothing."""
    each = list(values)
    return float(np.mean(each)) if each else None


def share(flags: Iterable[bool]) -> float | None:
    """Return the share of True, None of nothing."""
    return mean(flags)
