# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of the reports on demos, real logs, robot maps, recordings and speed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
import math
from statistics import median

from fpnet_lab.scores import (
    Column,
    Figures,
    Row,
    Score,
    Table,
    Unit,
    Units,
    named,
    of,
    share_of,
    together,
)

# Chosen: target of the demo for every seed.
_TARGET_POSITION_M, _TARGET_YAW_DEG = 0.5, 3.0
_COUNT = Units.COUNT.to(0, '-')  # numerical: digits
_DEMO = (  # numerical: digits
    Column('seed', 'name'),
    Column('poses', 'poses', _COUNT),
    Column('wrong', 'wrong_poses', _COUNT),
    Column('first pose', 'time_to_first_pose_s', Units.SECONDS.in_title(2, '-')),
    Column('after', 'path_to_first_pose_m', Units.METRES.in_title(2, '-')),
    Column('position', 'median_position_error_m', Units.METRES.in_title(2, '-')),
    Column('yaw', 'median_yaw_error_deg', Units.DEGREES.in_title(2, '-')),
    Column('tick p50', 'tick_ms_p50', Units.MS.in_title(2, '-')),
    Column('tick p95', 'tick_ms_p95', Units.MS.in_title(2, '-')),
)
_BY_ADVICE, _AT_RANDOM = 'by advice', 'any edge of what was seen'
_POLICIES = {
    _BY_ADVICE: 'advice', 'the nearest edge of what was seen': 'nearest', _AT_RANDOM: 'random',
}  # fmt: skip
_EXPLORED = (  # numerical: digits
    Column('goes', 'name'),
    Column('buildings', 'buildings', _COUNT),
    Column('localised', 'localised', Units.SHARE),
    Column('driven until then, mean', 'mean_m', Units.PATH),
    Column('median', 'median_m', Units.PATH),
    Column('wrong', 'wrong', _COUNT),
)
_SHORT = (  # numerical: digits
    Column('path', 'name'),
    Column('submaps', 'pieces', _COUNT),
    Column('seen', 'seen_m2', Units.AREA),
    Column('right', 'right', Units.SHARE),
    Column('claimed and right', 'claimed_right', Units.SHARE),
    Column('claimed and wrong', 'wrong', _COUNT),
    Column("claimed on another building's plan", 'foreign', _COUNT),
    Column('time', 'seconds', Units.SECONDS.to(2)),
)
_TO_FIRST = (('time_to_first_pose_s', Units.SECONDS), ('path_to_first_pose_m', Units.METRES))
_FIRST = together(*((key, unit.to(0)) for key, unit in _TO_FIRST))  # numerical: digits
_ERROR = (('median_position_error_m', Units.METRES), ('median_yaw_error_deg', Units.DEGREES))
_LOGS = (
    Column('log', 'log'),
    Column('said of the scale', 'name'),
    Column('status at the end', lambda run: run['status_over_time'][-1]),
    Column('first pose', lambda run: f'after {_FIRST(run)}' if run['poses'] else 'none'),
    Column('poses', 'poses'),
    Column('wrong', lambda run: run['wrong_poses'] or 0),
    Column('median error', together(*_ERROR)),
)
_PROGRAMS = (  # numerical: digits
    Column('sensor', 'sensor'),
    Column('program', 'program'),
    Column('first pose after', 'path_to_first_pose_m', Units.PATH),
    Column('poses', 'poses'),
    Column('wrong', 'wrong_poses'),
    Column("poses on another building's plan", 'poses_on_others'),
    Column('median error', together(*_ERROR)),
    Column('processor', 'processor_s', Units.SECONDS),
)
_NAMES = {'whole': 'whole', '50-100': 'half', '20-35': 'third', '10-20': 'tenth'}
_PARTS = ('50-100', '20-35', '10-20')
_MAPS = (
    Column('cases', 'cases'),
    Column('band', 'name'),
    Column('right', 'right', Units.SHARE),
    Column('claimed, right', 'claimed_right', Units.SHARE),
    Column('claimed, wrong', share_of('wrong_and_claimed', 'pairs')),
    Column("claimed on other buildings' plans", share_of('foreign_claimed', 'foreign_pairs')),
)
_WITHHELD = (('withheld_s_median', Units.SECONDS), ('withheld_s_max', Units.SECONDS))
_CARRIED = (
    Column('with', 'name'),
    Column('localized when lifted', 'localized'),
    Column('withheld', 'withheld'),
    Column('after, median and most', together(*_WITHHELD)),
    Column('wrong poses', 'wrong_poses'),
    Column('found again', 'found_again'),
    Column('right poses', 'right_poses'),
)

_RECOVERY = (('recovery_s_median', Units.SECONDS), ('recovery_s_max', Units.SECONDS))
_FAULTS = (
    Column('fault', 'name'),
    Column('localized before', of('before', 'drives')),
    Column('recovered', 'recovered'),
    Column('after, median and most', together(*_RECOVERY)),
    Column('poses off', 'off'),
    Column('longest', 'longest_s', Units.SECONDS),
    Column('drives off for more than 1 s', 'long_off'),
    Column('wrong poses', 'wrong'),
    Column('time localized', 'localized', Units.SHARE),
    Column('first pose', 'first_m', Units.PATH),
    Column('median error', 'median_m', Units.METRES),
)

_ENDS = (
    Column('nodes are', 'name'),
    Column('clean ends', of('clean', 'launches')),
    Column('took', together(('took_s_median', Units.SECONDS), ('took_s_max', Units.SECONDS))),
)

_NOT_TRIED = dict.fromkeys(('localised', 'wrong', 'off', 'first_m', 'median_m', 'median_deg'))


def _localised(row: Row) -> str:
    return '' if row['localised'] is None else f'{row["localised"]} of {row["walks"]}'


_WALKS = (  # numerical: digits
    Column('odometry', 'name'),
    Column('localised', _localised),
    Column('wrong poses', 'wrong'),
    Column('poses off', 'off'),
    Column('first pose', 'first_m', Units.PATH),
    Column('median error', together(('median_m', Units.METRES), ('median_deg', Unit('°', 1)))),
    Column('off after 1 s', together(('second_m', Units.METRES), ('second_deg', Unit('°', 1)))),
    Column('most', 'second_m_max', Units.METRES),
    Column('length of path', 'path_max', Units.NUMBER),
    Column('time of a core', 'register_ms', Units.MS),
)
_WALKED_LOG = (  # numerical: digits
    Column('odometry', 'name'),
    Column(
        'off after ten scans', together(('second_m', Units.METRES), ('second_deg', Unit('°', 1)))
    ),
    Column('length of path', 'path', Units.NUMBER),
    Column('time of a core', 'register_ms', Units.MS),
)
_ODOMETRIES = {
    'with a gyroscope': 'gyro',
    'scans alone': 'scans',
    "kiss-icp's own class": 'kiss_icp',
}

_MB = Unit(' MB')
_HOUR = (  # numerical: digits
    ('tick, median', 'tick_ms_p50', Units.MS),
    ('tick, 95th percentile', 'tick_ms_p95', Units.MS),
    ('`add_scan`, median', 'add_scan_ms_p50', Units.MS.to(1)),
    ('memory held, simulator included', 'rss_mb_max', _MB),
)
# Chosen, limits at the end of an hour of driving:
_AIM_TICK_MS, _AIM_ADD_SCAN_MS, _AIM_SLOWER, _AIM_MEMORY_MB = 200.0, 10.0, 1.5, 1200.0

_GRID, _GRID_SAID = 'grid', 'clean floorplan, scale stated'
_WRONG_M = 1.0  # chosen: error from which an accepted pose is wrong
_SHEETS = (
    Column('sheet', 'name'),
    Column('found', of('found', 'drives')),
    Column('wrong by over 1 m', 'wrong'),
    Column('doubted by the reader', 'doubted'),
    Column('first pose, median', 'after_m', Units.PATH),
    Column("over the grid's", 'ratio', Units.NUMBER),
    Column('error', 'error_m', Units.METRES),
)

_DURATION = Units.SECONDS.in_title(4)  # numerical: digits
_SPEED = (
    Column('what', 'name'),
    Column('by the clock', 'seconds', _DURATION),
    Column('of the processor', 'cpu_s', _DURATION),
    Column('aim', lambda row: Score('', row['seconds'], Unit(digits=3), row['aim_s']).said_aim),
)


def demo(report: Row) -> Figures:
    """Return one row for each seed of the demo, and the number of seeds that meet the target."""
    seeds = report['seeds']
    paths = [run['path_to_first_pose_m'] for run in seeds.values()]
    values = {
        'met': f'{sum(_is_met(run) for run in seeds.values())} of {len(seeds)}',
        'wrong': str(sum(run['wrong_poses'] for run in seeds.values())),
        'latest': 'never' if None in paths else Units.PATH.text(max(paths)),
    }
    return {'': Table.of(_DEMO, named(seeds))}, values


def _is_met(run: Row) -> bool:
    scores = (
        Score('wrong poses', run['wrong_poses'], Units.COUNT, 0),
        Score('position', run['median_position_error_m'], Units.METRES, _TARGET_POSITION_M),
        Score('yaw', run['median_yaw_error_deg'], Units.DEGREES, _TARGET_YAW_DEG),
    )
    return bool(run['localized']) and all(score.is_met for score in scores)


def real_logs(report: Row) -> Figures:
    """Return a row for each log and each stated scale of its drawing."""
    rows = [{**row, 'log': log} for log, ways in report['logs'].items() for row in named(ways)]
    return {'': Table.of(_LOGS, rows)}, {}


def robot(report: Row) -> Figures:
    """Return the results of ``fpnet`` on real robot maps, by explored share and by building."""
    figures = report['methods']['fpnet']
    groups = {
        'all': figures['bands'],
        'without the three distorted drawings': figures['bands_undistorted'],
    }
    rows = [
        {**row, 'cases': title if row['name'] == 'whole' else ''}
        for title, bands in groups.items()
        for row in named(bands)
    ]
    tables = {'': Table.of(_MAPS, rows), 'buildings': _buildings(figures['buildings'])}
    values = {
        'pairs': str(_count(figures['bands'], 'pairs')),
        'wrong': str(_count(figures['bands'], 'pairs', 'wrong_and_claimed')),
        'foreign': str(_count(figures['bands'], 'foreign_pairs', 'foreign_claimed')),
        'foreign_pairs': f'{_count(figures["bands"], "foreign_pairs"):,}',
    }
    for title, bands in (('right', 'bands'), ('undistorted', 'bands_undistorted')):
        for band, name in _NAMES.items():
            values[f'{title}_{name}'] = Units.SHARE.text(figures[bands][band]['right'])
    return tables, values


def _count(bands: Mapping[str, Row], cases: str, share: str | None = None) -> int:
    """Return the number of cases of all bands, or of those counted by a share of each band."""
    return sum(
        round(row[cases] * (1.0 if share is None else row[share])) for row in bands.values()
    )


def _buildings(by_name: Mapping[str, Row]) -> Table:
    answers = together(('right', Units.SHARE.in_title(0)), ('claimed_right', Units.SHARE))
    rows = []
    for name, bands in by_name.items():
        wrong = sum(round(each['wrong_and_claimed'] * each['pairs']) for each in bands.values())
        claims = f'{wrong} of {sum(each["pairs"] for each in bands.values())}'
        row = {'name': f'`{name}`', 'maps': bands['whole']['pairs'], 'wrong': claims}
        rows.append(row | {band: answers(bands[band]) for band in _PARTS})
    parts = (Column(f'{band} %', band) for band in _PARTS)
    titles = (Column('building', 'name'), Column('maps', 'maps'), *parts)
    return Table.of([*titles, Column('claimed, wrong', 'wrong')], rows)


def drift(report: Row) -> Figures:
    """Return pose errors while localized: on exact and rough drawings, and with wheel odometry."""
    ways = {'whole_submap': 'whole submap', 'published': 'published'}
    exact = {'odometry': 'odometry from a right start', **ways}
    most, median = ('max_m', Units.METRES), ('p50_m', Units.METRES)
    often = ('p95_m', Units.METRES), ('p95_deg', Units.DEGREES)
    drives = {
        drawing: [{**drive[drawing], 'name': _drive(drive)} for drive in report['drives']]
        for drawing in ('exact', 'rough', 'wheels')
    }
    tables = {
        '': _drives(drives['exact'], exact, together(most), ''),
        'rough': _drives(drives['rough'], ways, together(median, most), 'never claimed'),
        'wheels': _drives(drives['wheels'], ways, together(*often), 'never claimed'),
    }
    return tables, {}


def _drive(drive: Row) -> str:
    return f'{drive["family"].replace("_", " ")}, {Units.METRES.to(0).text(drive["path_m"])}'


def _drives(
    drives: Sequence[Row], ways: Mapping[str, str], shown: Callable[[Row], str], nothing: str
) -> Table:
    rows = [
        {'name': drive['name']}
        | {way: shown(drive[way]) if way in drive else nothing for way in ways}
        for drive in drives
    ]
    titles = (Column(title, way) for way, title in ways.items())
    return Table.of([Column('building, path', 'name'), *titles], rows)


def carried_off(report: Row) -> Figures:
    """Return the results of the kidnapping benchmark."""
    titles = {
        'the walls around the robot are asked': 'asked',
        'they are not (`localizer.doubt_probability=1`)': 'not_asked',
    }
    rows = named({title: report['ways'][way] for title, way in titles.items()})
    return {'': Table.of(_CARRIED, rows)}, {'drives': str(len(report['drives']))}


def faults(report: Row) -> Figures:
    """Return what is published while inputs are faulty."""
    return {'': Table.of(_FAULTS, named(report['faults']))}, {}


def clean_ends(report: Row) -> Figures:
    """Return how nodes exit after two signals, by their activity."""
    return {'': Table.of(_ENDS, named(report['when']))}, {}


def guidance(report: Row) -> Figures:
    """Return the path lengths until robots are localized, by exploration policy."""
    rows = {title: report['policies'][key] for title, key in _POLICIES.items()}
    share = rows[_BY_ADVICE]['mean_m'] / rows[_AT_RANDOM]['mean_m']
    return {'': Table.of(_EXPLORED, named(rows))}, {
        'of_random': Units.NUMBER.text(share),
        'nowhere': str(report['nowhere']),
    }


def short_submaps(report: Row) -> Figures:
    """Return the localization rates of short submaps, by path length."""
    return {'': Table.of(_SHORT, named(report['paths']))}, {}


def walks(report: Row) -> Figures:
    """Return the results for a hand-held lidar."""
    rows = {title: _NOT_TRIED | report['odometries'][key] for title, key in _ODOMETRIES.items()}
    log = {title: report['log'][key] for title, key in _ODOMETRIES.items() if key in report['log']}
    tables = {'': Table.of(_WALKS, named(rows)), 'log': Table.of(_WALKED_LOG, named(log))}
    return tables, {}


def long_run(report: Row) -> Figures:
    """Return call durations early and late in a long recording, and the aims."""
    early, late = report['early'], report['late']
    titles = (
        f'at {early["minute"]:.0f} minutes, exploring',
        f'at {late["minute"]:.0f} minutes',
    )
    rows = [[what, *(unit.text(part[key]) for part in (early, late))] for what, key, unit in _HOUR]
    slower = report['late_over_early_tick_cpu_p50']
    scores = (
        Score('tick, 95th percentile', late['tick_ms_p95'], Units.MS, _AIM_TICK_MS),
        Score('`add_scan`, median', late['add_scan_ms_p50'], Units.MS.to(1), _AIM_ADD_SCAN_MS),
        Score('tick, median, of that early', slower, Units.NUMBER, _AIM_SLOWER),
        Score('memory held', late['rss_mb_max'], _MB, _AIM_MEMORY_MB),
    )
    tables = {'': Table(('figure', *titles), rows), 'aims': Table.of_aims(scores)}
    return tables, {'explored': Unit(' m²').text(report['explored_m2'])}


def sheet_drives(report: Row) -> Figures:
    """Return the paths to the first pose on each kind of sheet, also relative to grids."""
    by_sheet: dict[str, list[Row]] = {}
    for drive in report['drives']:
        by_sheet.setdefault(drive['sheet'], []).append(drive)
    grid_m = {drive['seed']: drive['found_after_m'] for drive in by_sheet[_GRID]}
    rows = [_on_sheets(name, drives, grid_m) for name, drives in by_sheet.items()]
    return {'': Table.of(_SHEETS, rows)}, {}


def _on_sheets(name: str, drives: Sequence[Row], grid_m: Mapping[int, float | None]) -> Row:
    """Return the figures of one kind of sheet; a run without a pose counts as infinitely late."""
    after_m = [math.inf if d['found_after_m'] is None else d['found_after_m'] for d in drives]
    found = [drive for drive in drives if drive['found_after_m'] is not None]
    ratio = [d['found_after_m'] / path_m for d in found if (path_m := grid_m[d['seed']])]
    median_m = median(after_m)
    return {
        'name': _GRID_SAID if name == _GRID else name.replace(' ', ', '),
        'drives': len(drives),
        'found': len(found),
        'wrong': sum(drive['error_m'] > _WRONG_M for drive in found),
        'doubted': sum(bool(drive['doubts']) for drive in drives),
        'after_m': 'none' if math.isinf(median_m) else median_m,
        'ratio': median(ratio) if ratio and name != _GRID else None,
        'error_m': median(drive['error_m'] for drive in found) if found else None,
    }


def speed(report: Row) -> Figures:
    """Return the durations of interactive operations with their aims."""
    return {'': Table.of(_SPEED, named(report['figures']))}, {}


def two_programs(report: Row) -> Figures:
    """Return the results of two program versions on the same recordings, and the time ratio."""
    drives = report['drives']
    ratios = [drive['today']['processor_s'] / drive['earlier']['processor_s'] for drive in drives]
    rows = [{'sensor': drive['sensor'], **drive[name], 'program': said}
            for drive in drives
            for name, said in (('earlier', report['commit']), ('today', 'today'))]  # fmt: skip
    return {'': Table.of(_PROGRAMS, rows)}, {'times': Units.NUMBER.text(median(ratios))}
