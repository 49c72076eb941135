# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the documentation shows of ``fpnet bench sites``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fpnet_lab.evaluation.figures import markdown_table

Report = Mapping[str, Any]

_KINDS = {
    'apart': 'storeys differ by 10 % of their walls or more',
    'equal': 'two storeys are equal',
}


def sites(report: Report) -> tuple[dict[str, str], dict[str, str]]:
    """Return the tables of storeys and of differences, as far as they were measured."""
    tables = {}
    if 'sites' in report:
        tables[''] = _storeys(report['sites'])
    if 'one' in report:
        tables['one'] = _one(report['one'])
    if 'differences' in report:
        tables['differences'] = _differences(report['differences'])
    if 'library' in report:
        tables['library'] = _library(report['library'])
        tables['growth'] = _growth(report['library']['growth'])
    return tables, {}


def _storeys(part: Report) -> str:
    header = ['sites of 2 to 12 storeys', 'drives', 'right after 40 m', 'wrong storey claimed']
    header += [
        'first claim',
        'on one plan',
        'a wall that differs seen',
        'mean tick',
        'on one plan',
        'with 12 storeys',
    ]
    rows = [
        [
            title,
            str(row['sites']),
            _right(name, row),
            str(row['wrong_storeys']),
            _with(row['path_m_median'], '{:.1f} m'),
            _with(row['path_alone_m_median'], '{:.1f} m'),
            _with(row['parted_m_median'], '{:.1f} m'),
            _with(row['tick_ms_mean'], '{:.0f} ms'),
            _with(row['tick_alone_ms_mean'], '{:.0f} ms'),
            _with(row['tick_ratio_12'], '{:.1f} times'),
        ]
        for name, title in _KINDS.items()
        if (row := part[name])['sites']
    ]
    return markdown_table(header, rows)


def _right(name: str, row: Report) -> str:
    if name == 'equal':
        return f'ambiguous {row["ambiguous"]}'
    return str(row['right'])


def _one(row: Report) -> str:
    header = ['the same drive', 'on the floorplan', 'on a site of it alone']
    header += ['ratio, median', 'its quartiles apart']
    rows = [
        [
            title,
            f'{row[name]:.2f} ms',
            f'{row[f"{name}_site"]:.2f} ms',
            f'{row[f"{name}_ratio"]:.3f}',
            f'{row[f"{name}_ratio_spread"]:.3f}',
        ]
        for name, title in (('tick_ms', 'tick, median'), ('scan_ms', 'adding a scan, median'))
    ]
    said = f'Poses are equal to the last bit on {row["same"]} of {row["drives"]} drives.'
    return f'{markdown_table(header, rows)}\n\n{said}'


def _differences(row: Report) -> str:
    shown = {
        'precision': f'{100.0 * row["precision"]:.0f} %',
        'recall where seen': f'{100.0 * row["recall"]:.0f} %',
        'furniture taken for wall': f'{100.0 * row["furniture_as_wall"]:.0f} %',
        'false ones on exact drawings': f'{row["false_per_100_m"]:.1f} per 100 m of wall',
        'found': str(row['pieces']),
        'there': str(row['true_pieces']),
    }
    return markdown_table(list(shown), [list(shown.values())])


def _library(part: Report) -> str:
    header = ['seen', 'asked', 'first', 'among the first 10', 'query, median']
    rows = [
        [
            group,
            str(row['cases']),
            f'{100.0 * row["first"]:.0f} %',
            f'{100.0 * row["in_first_10"]:.0f} %',
            f'{row["query_ms_median"]:.0f} ms',
        ]
        for group, row in part['groups'].items()
    ]
    claims = part['claims']
    said = (
        f'{part["plans"]} plans, {part["kilobytes_a_plan"]:.1f} kB each. After a search of the '
        f'first 10, {100.0 * claims["right"]:.0f} % of the drives are claimed right and '
        f'{100.0 * claims["wrong"]:.1f} % wrong.'
    )
    return f'{markdown_table(header, rows)}\n\n{said}'


def _growth(rows: Sequence[Report]) -> str:
    header = ['plans', 'index', 'query, median', 'among the first 10']
    cells = [
        [
            f'{row["plans"]:,}',
            f'{row["megabytes"]:.0f} MB',
            f'{row["query_ms_median"]:.0f} ms',
            f'{100.0 * row["in_first_10"]:.0f} %',
        ]
        for row in rows
    ]
    return markdown_table(header, cells)


def _with(value: float | None, shown: str) -> str:
    return '' if value is None else shown.format(value)
