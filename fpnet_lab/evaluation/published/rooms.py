# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of the reports on rooms, doors, scales and matches."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fpnet_lab.metrics import mean
from fpnet_lab.scores import (
    Column,
    Figures,
    Row,
    Score,
    Table,
    Units,
    columns,
    named,
    of,
    reports_of,
)

# Numerical, digits:
_TENTH, _IOU = Units.FINE_SHARE, Units.NUMBER
_ROOMS = columns(_TENTH, {'precision': 'P', 'recall': 'R', 'f1': 'F1'})
_PLANS = (
    Column('method', 'method'),
    Column('plans', 'name'),
    *_ROOMS,
    *columns(_TENTH, {'doors_precision': 'door P', 'doors_recall': 'door R'}),
    Column('a map', 'seconds_per_map_median', Units.SECONDS.to(2)),
)
_MAPS = (Column('method', 'method'), Column('maps', 'name'), *_ROOMS)
_DRIVES = (
    Column('sensor', 'name'),
    Column('drives', 'recordings'),
    Column('rooms', 'rooms'),
    *columns(_IOU, {'room_iou_mean': 'room IoU', 'rooms_over_iou50': 'over 0.5'}),
    *columns(_IOU, {'doors_precision': 'doors P', 'doors_recall': 'doors R'}),
)
_SENSORS = {
    'beams16': '16 beams, ±15°',
    'beams32': '32 beams, ±22.5°',
    'beams64': '64 beams, ±45°',
    'dome': 'dome, 360 x 59°, never repeating',
    'planar': 'planar',
}
_SCALES = (
    Column('drawings', 'name'),
    Column('n', 'estimates'),
    *columns(Units.SHARE, {'within_10': 'within 10 %', 'held': '90 % interval holds'}),
    Column('high / low', 'spread', _IOU),
    *columns(Units.SHARE, {'sure': 'called sure', 'sure_wrong': 'of all, sure and wrong'}),
    Column('a drawing', 'ms_per_drawing', Units.MS),
)
_GROUPS = {
    'tune bare': 'tune half',
    'tune furnished': 'tune half, furnished',
    'report bare': 'report half',
    'report furnished': 'report half, furnished',
    'homes': 'generated homes',
    'practices': 'generated small offices',
    'houses': 'generated houses of large rooms',
}

_LOST = Units.NUMBER.to(3)  # numerical: digits
_LOSSES = (
    Column('sensor', 'name'),
    Column('rooms', 'rooms'),
    *columns(_LOST, {'shipped': 'IoU', 'decided': 'decided', 'cut': 'cut'}),
    *columns(_LOST, {name: name for name in ('returns', 'unseen', 'free', 'beyond')}),
)
_SURVEYS = {'terrestrial': 'terrestrial', 'slam': 'SLAM map'}
_CLOUDS = (
    Column('cloud', 'name'),
    Column('storeys', 'storeys'),
    Column('rooms', 'rooms'),
    Column('room IoU', 'iou', _IOU),
    Column('found', 'found', Units.SHARE),
    Column('matched', of('matched', 'storeys')),
    Column('IoU, two storeys in one cloud, strays around', 'of_two', _IOU),
)

# Chosen, least values of the figures for rooms, doors and matches:
_OF_PLANS = {
    'clean': {'f1': 0.94, 'doors_precision': 0.96, 'doors_recall': 0.92},
    'furnished': {'f1': 0.92, 'doors_precision': 0.94, 'doors_recall': 0.91},
}
_OF_MAPS, _OF_SENSORS, _OF_PLANAR = 0.70, 0.88, 0.86
_OF_DRIVES = {
    'room_iou_mean': ('room IoU, mean', _IOU.to(3), 0.92),
    'doors_precision': ('doors P', _IOU.to(3), 0.94),
    'doors_recall': ('doors R', _IOU.to(3), 0.94),
    'rooms_over_iou50': ('rooms found', _TENTH, 0.97),
}
_OF_MATCHES = {
    'synthetic': {'ts': 1.0, 'ms': 0.95, 'auc10': 0.94},
    'real': {'ts': 0.97, 'ms': 0.82, 'auc10': 0.86},
    'challenging': {'ts': 0.82, 'ms': 0.85, 'auc10': 0.65},
    'tours': {},
}
_TITLES = {
    'f1': 'F1 of rooms',
    'doors_precision': 'door P',
    'doors_recall': 'door R',
    'ts': 'TS',
    'ms': 'MS',
    'auc10': 'AUC@10',
    'recall_1m_10deg': '1 m, 10°',
}


def segmentation(report: Row) -> Figures:
    """Return figures of floorplans and robot maps by method, and the aims."""
    methods = {'default': report, **report['baselines']}
    plans = [
        {**figures[kind], 'method': method, 'name': kind}
        for method, figures in methods.items()
        for kind in _OF_PLANS
    ]
    maps = report['robot_maps']
    own = {half: f'{half} half' for half in ('tune', 'report') if half in maps}
    rows = [{**maps[half], 'method': 'default', 'name': title} for half, title in own.items()]
    rows += [{**maps[m], 'method': m, 'name': f'all {maps["maps"]}'} for m in methods]
    left_out = ', '.join(maps['left_out']) or 'none'
    tables = {
        '': Table.of(_PLANS, plans, f'{report["plans"]} floorplans.'),
        'maps': Table.of(_MAPS, rows, f'Left out: {left_out}.'),
        'aims': Table.of_aims(_plan_scores(report)),
    }
    return tables, {'seconds': _PLANS[-1].unit.text(plans[0]['seconds_per_map_median'])}


def _plan_scores(report: Row) -> list[Score]:
    scores = [
        _at_least(f'{kind}, {_TITLES[key]}', report[kind][key], aim)
        for kind, aims in _OF_PLANS.items()
        for key, aim in aims.items()
    ]
    half = report['robot_maps'].get('report')
    told = None if half is None else half['f1']
    return [*scores, _at_least("robots' maps of the report half, F1", told, _OF_MAPS)]


def _at_least(name: str, value: float | None, aim: float | None) -> Score:
    return Score(name, value, _TENTH, aim, is_floor=True)


def submaps(report: Row) -> Figures:
    """Return figures of rooms and doors for each sensor, and the aims."""
    drives = report['submap']
    by_sensor = drives['by_sensor']
    rows = {_SENSORS[name]: row for name, row in by_sensor.items()} | {'all': drives}
    scores = [
        Score(name, drives[key], unit, aim, is_floor=True)
        for key, (name, unit, aim) in _OF_DRIVES.items()
    ]
    for name, row in by_sensor.items():
        aim = _OF_PLANAR if name == 'planar' else _OF_SENSORS
        said = f'room IoU, {_SENSORS[name].partition(",")[0]}'
        scores.append(Score(said, row['room_iou_mean'], _IOU.to(3), aim, is_floor=True))
    return {'': Table.of(_DRIVES, named(rows)), 'aims': Table.of_aims(scores)}, {}


def submap_losses(report: Row) -> Figures:
    """Return where rooms of submaps lose intersection over union, by sensor."""
    sensors = report['sensors'].items()
    rows = {_SENSORS.get(name, name).partition(',')[0]: row for name, row in sensors}
    return {'': Table.of(_LOSSES, named(rows))}, {}


def finished_clouds(report: Row) -> Figures:
    """Return segmentation and matching of the clouds of each survey, by first storey seed."""
    rows = []
    for run in reports_of(report):
        for how in dict.fromkeys(cloud['how'] for cloud in run['clouds']):
            clouds = [cloud for cloud in run['clouds'] if cloud['how'] == how]
            name = f'{_SURVEYS.get(how, how)}, seed {run["seed"]}'
            rows.append({**_of_clouds(clouds), 'name': name})
    return {'': Table.of(_CLOUDS, rows)}, {}


def _of_clouds(clouds: Sequence[Row]) -> Row:
    """Return the pooled figures of the clouds of one survey; rooms have equal weight."""
    rooms = [cloud['rooms'] for cloud in clouds]
    means = {
        key: float(np.average([cloud[key] for cloud in clouds], weights=rooms))
        for key in ('found', 'iou')
    }
    of_two = [iou for cloud in clouds for iou in cloud['of_two']]
    counts = {
        'storeys': len(clouds),
        'rooms': sum(rooms),
        'matched': sum(cloud['status'] == 'matched' for cloud in clouds),
    }
    return means | counts | {'of_two': mean(of_two)}


def scale(report: Row) -> Figures:
    """Return the accuracy of scales estimated from drawings, by kind of drawing."""
    groups = report['groups']
    values: dict[str, str] = {}
    for name, key in (('homes', 'homes'), ('report bare', 'report')):
        if name in groups:
            factors = [row['factor'] for row in report['drawings'] if row['group'] == name]
            values[f'{key}_times'] = _IOU.to(1).text(float(np.median(factors)))
            values[f'{key}_held'] = Units.SHARE.text(groups[name]['held'])
    rows = {_GROUPS.get(name, name): row for name, row in groups.items()}
    return {'': Table.of(_SCALES, named(rows))}, values


def matches(pair_set: str) -> Callable[[Row], Figures]:
    """Return a function that makes the table of this project's matcher on one pair set."""

    def make(report: Row) -> Figures:
        figures = report['methods']['fpnet']
        keys: Sequence[str] = ('ts', 'ms', 'auc10', 'recall_1m_10deg')
        aims = _OF_MATCHES[pair_set]
        scores = [_at_least(_TITLES[key], figures[key], aims.get(key)) for key in keys]
        table = Table.of_aims(scores)
        rows = [[*row[:3], row[3] if row[2] else ''] for row in table.rows]
        titles = (f'`{pair_set}`, {report["pairs"]} pairs', *table.titles[1:])
        return {'': Table(titles, rows)}, {}

    return make


MATCHES: dict[str, Callable[[Row], Figures]] = {
    f'matching_{name}': matches(name) for name in _OF_MATCHES
}
"""Functions by name of the published table."""
