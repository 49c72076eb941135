# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Comparison of all methods on the same recordings, one row per method."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fpnet_lab.evaluation.localization.cases import ROUGH_GROUP
from fpnet_lab.evaluation.localization.figures import median
from fpnet_lab.evaluation.localization.records import Record
from fpnet_lab.scores import Column, Figures, Row, Table, Units, named, of

# Numerical, digits:
_PLACED = (
    Column('method', 'name'),
    Column('right', of('right', 'runs')),
    Column('claimed, right', of('claimed_right', 'runs')),
    Column('claimed, wrong', of('claimed_wrong', 'runs')),
)
_FOREIGN = "claims on other buildings' plans"
_ON_DRIVES = (
    *_PLACED,
    Column('first pose', 'first_pose_m', Units.PATH.to(1, 'none')),
    Column(_FOREIGN, of('foreign_claims', 'foreign')),
    Column('error', 'error_m', Units.METRES.to(2, 'none')),
    Column('a look', 'look_s', Units.SECONDS.to(3, 'none')),
)
_ON_MAPS = (*_PLACED, Column(_FOREIGN, 'foreign'), Column('a map', 'map_s', Units.SECONDS.to(2)))


def peer_figures(records: Sequence[Record]) -> dict[str, dict[str, Any]]:
    """
    Return the figures of each method.

    ``runs`` with a right answer, of which ``right`` (1 m and 10 degrees after 40 m),
    ``claimed_right`` (accepted, never more than 3 m or 30 degrees off), ``claimed_wrong`` (so at
    some time); medians ``first_pose_m`` and ``error_m`` over runs with a pose, ``look_s`` over
    updates. Of other buildings' plans, those run by all methods (``foreign``) and accepted
    (``foreign_claims``).
    """
    kept = [record for record in records if record.group != ROUGH_GROUP]
    methods = dict.fromkeys(record.method for record in kept)
    met = [{(r.case, r.plan) for r in kept if r.method == name} for name in methods]
    common = set.intersection(*met) if met else set()
    return {
        name: _figures([r for r in kept if r.method == name and (r.case, r.plan) in common])
        for name in methods
    }


def _figures(records: Sequence[Record]) -> dict[str, Any]:
    own = [record for record in records if not record.is_open_set]
    foreign = [record for record in records if record.is_open_set]
    looks = [ms for record in records for ms in record.tick_ms]
    return {
        'runs': len(own),
        'right': sum(record.is_right for record in own),
        'claimed_right': sum(record.poses > 0 and not record.wrong_poses for record in own),
        'claimed_wrong': sum(record.wrong_poses > 0 for record in own),
        'first_pose_m': median(record.path_to_first_pose_m for record in own),
        'error_m': median(record.median_position_error_m for record in own),
        'look_s': median(1e-3 * ms for ms in looks),
        'foreign': len(foreign),
        'foreign_claims': sum(record.poses > 0 for record in foreign),
    }


def peers(report: Row) -> Figures:
    """Return a row for each method: on recordings, and on robot maps of all bands."""
    tables = {'': Table.of(_ON_DRIVES, named(report['methods'], '`{}`'))}
    if 'maps' in report:
        rows = {name: _on_maps(figures) for name, figures in report['maps'].items()}
        tables['maps'] = Table.of(_ON_MAPS, named(rows, '`{}`'))
    return tables, {}


def _on_maps(figures: Row) -> dict[str, Any]:
    bands = figures['bands'].values()

    def count(share: str, cases: str) -> int:
        return sum(round((band[share] or 0.0) * band[cases]) for band in bands)

    foreign = sum(band['foreign_pairs'] for band in bands)
    claims = f'{count("foreign_claimed", "foreign_pairs")} of {foreign}'
    return {
        'runs': sum(band['pairs'] for band in bands),
        'right': count('right', 'pairs'),
        'claimed_right': count('claimed_right', 'pairs'),
        'claimed_wrong': count('wrong_and_claimed', 'pairs'),
        'foreign': claims if foreign else 'not asked',
        'map_s': 1e-3 * figures['ms_per_pair'],
    }
