# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Runs of all methods on the same drives, as one row for each method."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from fpnet_lab.evaluation.localization.cases import ROUGH_GROUP
from fpnet_lab.evaluation.localization.records import Record

COLUMNS = (
    'method', 'right', 'claimed, right', 'claimed, wrong', 'first pose',
    "claims on other buildings' plans", 'error', 'a look',
)  # fmt: skip
MAP_COLUMNS = (
    'method', 'right', 'claimed, right', 'claimed, wrong', "claims on other buildings' plans",
    'a map',
)  # fmt: skip


def peer_figures(records: Sequence[Record]) -> dict[str, dict[str, Any]]:
    """
    Return for each method what its runs come to.

    ``runs`` with a right answer, how many of them are ``right`` (1 m and 10 degrees after 40 m),
    ``claimed_right`` (and never more than 3 m or 30 degrees off), ``claimed_wrong`` (were so at
    some time), the median ``first_pose_m`` and ``error_m`` of runs that published a pose, and
    ``look_s``, the median time of a look. Of plans without a right answer, ``foreign`` that all
    methods met and ``foreign_claims`` on them.
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
        'first_pose_m': _median(record.path_to_first_pose_m for record in own),
        'error_m': _median(record.median_position_error_m for record in own),
        'look_s': _median(1e-3 * ms for ms in looks),
        'foreign': len(foreign),
        'foreign_claims': sum(record.poses > 0 for record in foreign),
    }


def _median(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return round(float(np.median(known)), 4) if known else None


def peer_rows(peers: Mapping[str, Mapping[str, Any]]) -> list[list[str]]:
    """Return the cells of :data:`COLUMNS`, one row for each method."""
    return [
        [
            f'`{name}`',
            *(f'{found[key]} of {found["runs"]}' for key in _COUNTS),
            _with_unit(found['first_pose_m'], 'm', 1),
            f'{found["foreign_claims"]} of {found["foreign"]}',
            _with_unit(found['error_m'], 'm', 2),
            _with_unit(found['look_s'], 's', 3),
        ]
        for name, found in peers.items()
    ]


def map_rows(methods: Mapping[str, Mapping[str, Any]]) -> list[list[str]]:
    """Return the cells of :data:`MAP_COLUMNS`: robots' maps of all bands, one row a method."""
    rows = []
    for name, figures in methods.items():
        bands = list(figures['bands'].values())
        pairs, foreign = (sum(band[key] for band in bands) for key in ('pairs', 'foreign_pairs'))
        counts = [
            sum(round((band[key] or 0.0) * band['pairs']) for band in bands) for key in _SHARES
        ]
        claims = sum(
            round((band['foreign_claimed'] or 0.0) * band['foreign_pairs']) for band in bands
        )
        asked = f'{claims} of {foreign}' if foreign else 'not asked'
        took = _with_unit(1e-3 * figures['ms_per_pair'], 's', 2)
        rows.append([f'`{name}`', *(f'{count} of {pairs}' for count in counts), asked, took])
    return rows


_SHARES = ('right', 'claimed_right', 'wrong_and_claimed')
_COUNTS = ('right', 'claimed_right', 'claimed_wrong')


def _with_unit(value: float | None, unit: str, digits: int) -> str:
    return 'none' if value is None else f'{value:.{digits}f} {unit}'
