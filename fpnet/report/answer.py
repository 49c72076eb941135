# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The result of a run in one line and five figures, and all its figures as a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fpnet.report.record import RunRecord
from fpnet_core.types import Status

Named = list[tuple[str, str]]

_ELSEWHERE = ('status', 'localized', 'reason', 'causes', 'outdated', 'next_look', 'claims')
"""Figures that other parts of the page show. Chosen."""

_NAMES = {
    'tick_ms_p50': 'update, median [ms]',
    'tick_ms_p95': 'update, 95th percentile [ms]',
    'nees_mean': 'NEES, mean (3 if consistent)',
    'inside_95': 'poses inside the 95 % ellipsoid',
    'sigma_position_m_median': 'standard deviation of position, median [m]',
    'sigma_yaw_deg_median': 'standard deviation of yaw, median [deg]',
    'storeys': 'probability of floors',
    'storey': 'floor',
}
_MAIN = {
    'first pose': (('path_to_first_pose_m', '.1f', ' m'), ('time_to_first_pose_s', '.0f', ' s')),
    'error, median': (
        ('median_position_error_m', '.2f', ' m'),
        ('median_yaw_error_deg', '.1f', '°'),
    ),
    'standard deviation, median': (
        ('sigma_position_m_median', '.2f', ' m'),
        ('sigma_yaw_deg_median', '.1f', '°'),
    ),
    'poses': (),
    'update, median': (('tick_ms_p50', '.0f', ' ms'),),
    'path': (('path_m', '.0f', ' m'),),
}
_COUNT = 5  # chosen: main figures
_UNITS = ('m', 's', 'ms', 'deg')


def answer_line(record: RunRecord) -> str:
    """Return where and how well the robot was localized; empty for a run without updates."""
    if not record.outputs:
        return ''
    last, figures = record.outputs[-1], record.figures
    after_m, after_s = figures.get('path_to_first_pose_m'), figures.get('time_to_first_pose_s')
    probability = f'p {last.probability:.2f}'
    if after_m is None:
        is_localized = last.status is Status.LOCALIZED
        words = 'Localized' if is_localized else f'Not localized: {last.status.value}'
        return f'{words}, {probability}'
    first = f'{after_m:.1f} m' + ('' if after_s is None else f' ({after_s:.0f} s)')
    if last.status is Status.LOCALIZED:
        return ', '.join([f'Localized at {first}', probability, *_accuracy(figures)])
    return f'Localized at {first}, but {last.status.value} at the end, {probability}'


def main_figures(record: RunRecord) -> Named:
    """Return the five main figures as names and texts, without those that are unknown."""
    texts = {name: _joined(record.figures, *parts) for name, parts in _MAIN.items()}
    texts['poses'] = _poses(record.figures)
    known = [(name, text) for name, text in texts.items() if text]
    return known[:_COUNT]


def all_figures(record: RunRecord) -> Named:
    """Return all figures as names with units and texts, without those that are unknown."""
    return [
        (_NAMES.get(name) or _named(name), _text(value))
        for name, value in record.figures.items()
        if value is not None and name not in _ELSEWHERE
    ]


def _accuracy(figures: Mapping[str, Any]) -> list[str]:
    """Return the error or, without ground truth, the standard deviation; empty if unknown."""
    if (error_m := figures.get('median_position_error_m')) is not None:
        return [f'error {error_m:.2f} m']
    if (sigma_m := figures.get('sigma_position_m_median')) is not None:
        return [f'standard deviation {sigma_m:.2f} m']
    return []


def _poses(figures: Mapping[str, Any]) -> str:
    count, wrong = figures.get('poses'), figures.get('wrong_poses')
    if count is None:
        return ''
    return f'{count}' if wrong is None else f'{count}, {wrong} wrong'


def _joined(figures: Mapping[str, Any], *parts: tuple[str, str, str]) -> str:
    """Return values with units, e.g. ``3.1 m, 12 s``; ``parts`` are keys, formats and units."""
    known = [(figures.get(key), form, unit) for key, form, unit in parts]
    return ', '.join(f'{value:{form}}{unit}' for value, form, unit in known if value is not None)


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return 'yes' if value else 'no'
    if isinstance(value, Mapping):
        return ', '.join(f'{name} {_text(each)}' for name, each in value.items())
    return f'{value:.2f}' if isinstance(value, float) else str(value)


def _named(name: str) -> str:
    """Turn ``path_to_first_pose_m`` into ``path to first pose [m]``."""
    words = name.split('_')
    units = [word for word in words if word in _UNITS]
    rest = ' '.join(word for word in words if word not in _UNITS)
    return f'{rest} [{units[-1]}]' if units else rest
