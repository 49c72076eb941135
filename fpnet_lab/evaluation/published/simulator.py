# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of the simulator reports: realism of storeys, throughput, cost of the lidars."""

from __future__ import annotations

from fpnet_lab.scores import (
    Column,
    Figures,
    Row,
    Score,
    Table,
    Unit,
    Units,
    named,
    reports_of,
)

# Numerical, digits:
_SHORT = Unit(digits=2, whole_from=10)
_PER_S, _TENTH = Unit(' per s', 1), Units.NUMBER.to(1)
_AIM_PAIRS_PER_S = 10.0
"""Chosen: target of the simulator on two cores."""

_QUANTITIES = {
    'room_area_m2': 'room area [m²]',
    'aspect': 'long over short side',
    'door_width_m': 'door width [m]',
    'rectangularity': 'rectangularity',
    'doors_per_room': 'doors per room',
    'rooms_per_plan': 'rooms per storey',
    'doors_of_hub': 'doors of the hub',
    'cycles_per_plan': 'cycles',
    'components_per_plan': 'components',
}
_CLOUDS = {
    'timed': 'with a time for each point',
    'untimed': 'without times',
    'instant': 'of one instant',
}
_RECORDINGS = (
    Column('sensor', 'name'),
    Column('clouds', 'clouds'),
    Column('rays', 'rays'),
    Column('scan', 'scan_ms', Units.MS),
    Column('odometry', 'odometry_ms', Units.MS),
    Column('m per 100 m', 'metres', _TENTH),
    Column('deg per 100 m', 'degrees', _TENTH),
    Column('at the end', 'end_m', Units.METRES),
)


def statistics(report: Row) -> Figures:
    """Return percentiles of generated and real storeys, and how separable their regions are."""
    titles = (
        f'{report["generated"]} generated / {report["real"]} real storeys',
        *(f'{percentile} %' for percentile in report['at']),
        'largest error',
    )
    rows = []
    for name, row in report['percentiles'].items():
        pairs = zip(row['generated'], row['real'], strict=True)
        cells = (f'{_SHORT.text(made)} / {_SHORT.text(real)}' for made, real in pairs)
        errors = (report['percentile_error'].get(f'{name}_p{at}') for at in report['at'])
        worst = max((abs(error) for error in errors if error is not None), default=None)
        rows.append([_QUANTITIES[name], *cells, Units.SHARE.text(worst)])
    values = {
        'auc': Units.NUMBER.text(report['regions_auc']),
        'spread': Units.NUMBER.text(report['regions_auc_spread']),
    }
    return {'': Table(titles, rows)}, values


def throughput(report: Row) -> Figures:
    """Return the number of pairs, plans and scans generated per second."""
    scores = (
        Score('pairs', report['pairs_per_s'], _PER_S, _AIM_PAIRS_PER_S, is_floor=True),
        Score('drawn plans', report['plans_per_s'], _PER_S),
        Score('sweeps of the 32-beam lidar', report['scans_per_s'], _PER_S),
    )
    table = Table.of_aims(scores)
    rows = [[*row[:3], row[3] if row[2] else ''] for row in table.rows]
    return {'': Table((f'{report["workers"]} workers', *table.titles[1:]), rows)}, {}


def recordings(report: Row) -> Figures:
    """Return scan time and odometry drift of each sensor; wheel odometry has no scans."""
    rows = [
        {**row, 'name': row['name'] if row['rays'] is None else f'`{row["name"]}`'}
        | {'clouds': '' if row['rays'] is None else _CLOUDS[run['clouds']]}
        for run in reports_of(report)
        for row in named(run['sensors'])
    ]
    return {'': Table.of(_RECORDINGS, rows)}, {}
