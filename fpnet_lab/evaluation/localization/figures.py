# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Figures of records: by group, by family and in total, for localizer and baselines."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from fpnet.accuracy import quantile
from fpnet_lab.evaluation.localization.cases import ROUGH_GROUP
from fpnet_lab.evaluation.localization.records import Record
from fpnet_lab.metrics import expected_calibration_error, mean

PRODUCT = 'fpnet'
"""The localizer's name among the methods."""

Figures = dict[str, float | int | None]


def report(records: Sequence[Record]) -> dict[str, Any]:
    """
    Return the figures of all methods.

    Returns
    -------
    ``{'total', 'groups', 'families', 'sensors', 'baselines': {name: the same four}}``. Families
    and sensors exclude open-set runs; only the groups include the rough drawings.
    """
    methods = dict.fromkeys(record.method for record in records)
    tables = {method: _tables([r for r in records if r.method == method]) for method in methods}
    baselines = {name: table for name, table in tables.items() if name != PRODUCT}
    return {**tables.get(PRODUCT, _tables([])), 'baselines': baselines}


def figures(records: Sequence[Record]) -> Figures:
    """
    Return the figures of several runs; None for figures without values.

    Recalls are shares of the runs with a right answer; ``open_set_false_claims`` and the
    ``wrong_published`` figures are counts. Medians are over runs. Runs without a published pose
    have no error and no path to the first pose. Means of ``nees_mean`` and ``inside_95`` are over
    the runs that published poses, with equal weights.
    """
    closed = [record for record in records if not record.is_open_set]
    wrong = [record.wrong_poses for record in closed]
    updates = np.concatenate([np.zeros(0), *(np.array(r.tick_ms) for r in records)])
    return {
        'recall_1m_10deg': _mean([record.is_right for record in closed]),
        'recall_05m_5deg': _mean([record.is_tight for record in closed]),
        'path_to_first_pose_m_median': median(r.path_to_first_pose_m for r in closed),
        'wrong_published_runs': int(np.count_nonzero(wrong)),
        'wrong_published_poses': int(np.sum(wrong, dtype=np.int64)),
        'median_position_error_m': median(r.median_position_error_m for r in closed),
        'median_yaw_error_deg': median(r.median_yaw_error_deg for r in closed),
        'nees_mean': _mean(_known(r.nees_mean for r in closed)),
        'inside_95': _mean(_known(r.inside_95 for r in closed)),
        'open_set_false_claims': sum(r.is_open_set and r.poses > 0 for r in records),
        'ece': calibration_error([estimate for r in records for estimate in r.beliefs]),
        'tick_ms_p50': _rounded(quantile(updates, 0.5)),
        'tick_ms_p95': _rounded(quantile(updates, 0.95)),
        'add_scan_ms_p50': median(r.add_scan_ms for r in records),
        'rss_mb_max': max((r.rss_mb for r in records), default=None),
        'runs': len(records),
    }


def calibration_error(beliefs: Sequence[tuple[float, bool]]) -> float | None:
    """Return the expected calibration error over ten equal bins; None for no estimates."""
    if not beliefs:
        return None
    p, right = (np.array(column) for column in zip(*beliefs, strict=True))
    return _rounded(expected_calibration_error(p, right))


def _tables(records: Sequence[Record]) -> dict[str, Any]:
    once = [record for record in records if record.group != ROUGH_GROUP]
    closed = [record for record in once if not record.is_open_set]
    return {
        'total': figures(once),
        'groups': _by(records, lambda record: record.group),
        'families': _by(closed, lambda record: record.building),
        'sensors': _by(closed, lambda record: record.sensor),
    }


def _by(records: Sequence[Record], key: Callable[[Record], str]) -> dict[str, Figures]:
    names = dict.fromkeys(key(record) for record in records)
    return {name: figures([r for r in records if key(r) == name]) for name in names}


def median(values: Iterable[float | None]) -> float | None:
    """Return the median of the known values, rounded; None if there are none."""
    return _rounded(quantile(_known(values), 0.5))


def _known(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def _mean(values: Sequence[float]) -> float | None:
    return _rounded(mean(values))


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)
