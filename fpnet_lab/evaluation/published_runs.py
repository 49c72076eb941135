# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports of demos, real logs, robots' maps and long drives to the tables that pages show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fpnet_lab.evaluation.figures import markdown_table

Report = Mapping[str, Any]
Figures = tuple[dict[str, str], dict[str, str]]

# Chosen: what the demo is to reach, of every seed.
_TARGET_POSITION_M, _TARGET_YAW_DEG = 0.5, 3.0
_DEMO = {
    'poses': 'poses',
    'wrong_poses': 'wrong',
    'time_to_first_pose_s': 'first pose [s]',
    'path_to_first_pose_m': 'after [m]',
    'median_position_error_m': 'position [m]',
    'median_yaw_error_deg': 'yaw [deg]',
    'tick_ms_p50': 'tick p50 [ms]',
    'tick_ms_p95': 'tick p95 [ms]',
}
_NAMES = {'whole': 'whole', '50-100': 'half', '20-35': 'third', '10-20': 'tenth'}
_PARTS = ('50-100', '20-35', '10-20')
_ANSWERS = ('right', 'claimed, right', 'claimed, wrong', "claimed on other buildings' plans")


def demo(report: Report) -> Figures:
    """Return the demo's runs, one row for each seed, and how many met the target."""
    seeds = report['seeds']
    rows = [[seed, *(_shown(run[key]) for key in _DEMO)] for seed, run in seeds.items()]
    paths = [run['path_to_first_pose_m'] for run in seeds.values()]
    values = {
        'met': f'{sum(_is_met(run) for run in seeds.values())} of {len(seeds)}',
        'wrong': str(sum(run['wrong_poses'] for run in seeds.values())),
        'latest': 'never' if None in paths else f'{max(paths):.1f} m',
    }
    return {'': markdown_table(['seed', *_DEMO.values()], rows)}, values


def _is_met(run: Report) -> bool:
    return bool(
        run['localized']
        and run['wrong_poses'] == 0
        and run['median_position_error_m'] <= _TARGET_POSITION_M
        and run['median_yaw_error_deg'] <= _TARGET_YAW_DEG
    )


def _shown(value: float | None) -> str:
    if value is None:
        return '-'
    return str(value) if isinstance(value, int) else f'{value:.2f}'


def real_logs(report: Report) -> Figures:
    """Return a row for each log and what was said of its drawing's scale."""
    rows = [
        [name, said, *_log(run)]
        for name, ways in report['logs'].items()
        for said, run in ways.items()
    ]
    header = ['log', 'said of the scale', 'status at the end', 'first pose', 'poses', 'wrong']
    return {'': markdown_table([*header, 'median error'], rows)}, {}


def _log(run: Report) -> list[str]:
    first, error = 'none', ''
    if run['poses']:
        first = f'after {run["time_to_first_pose_s"]:.0f} s, {run["path_to_first_pose_m"]:.0f} m'
        error = f'{run["median_position_error_m"]:.2f} m, {run["median_yaw_error_deg"]:.1f} deg'
    wrong = run['wrong_poses'] or 0
    return [run['status_over_time'][-1], first, str(run['poses']), str(wrong), error]


def robot(report: Report) -> Figures:
    """Return what ``fpnet`` says of real robots' maps, by what they have seen and by building."""
    figures = report['methods']['fpnet']
    groups = {
        'all': figures['bands'],
        'without the three distorted drawings': figures['bands_undistorted'],
    }
    rows = [
        [title if band == 'whole' else '', band, *_answers(shares)]
        for title, bands in groups.items()
        for band, shares in bands.items()
    ]
    tables = {
        '': markdown_table(['cases', 'band', *_ANSWERS], rows),
        'buildings': _buildings(figures['buildings']),
    }
    values = {'pairs': str(sum(shares['pairs'] for shares in figures['bands'].values()))}
    values |= {
        f'right_{name}': _per_cent(figures['bands_undistorted'][band]['right'])
        for band, name in _NAMES.items()
    }
    return tables, values


def _answers(shares: Report) -> list[str]:
    return [
        _per_cent(shares['right']),
        _per_cent(shares['claimed_right']),
        _of(shares['wrong_and_claimed'], shares['pairs']),
        _of(shares['foreign_claimed'], shares['foreign_pairs']),
    ]


def _buildings(by_name: Mapping[str, Report]) -> str:
    rows = []
    for name, bands in by_name.items():
        parts = [
            f'{100.0 * bands[band]["right"]:.0f}, {_per_cent(bands[band]["claimed_right"])}'
            for band in _PARTS
        ]
        wrong = [round(each['wrong_and_claimed'] * each['pairs']) for each in bands.values()]
        claims = f'{sum(wrong)} of {sum(each["pairs"] for each in bands.values())}'
        rows.append([f'`{name}`', str(bands['whole']['pairs']), *parts, claims])
    header = ['building', 'maps', *(f'{band} %' for band in _PARTS), 'claimed, wrong']
    return markdown_table(header, rows)


def _per_cent(share: float) -> str:
    return f'{100.0 * share:.0f} %'


def _of(share: float | None, count: int) -> str:
    return '' if share is None else f'{round(share * count)} of {count}'


def drift(report: Report) -> Figures:
    """Return the largest errors under a claim, of exact drawings and of rough ones."""
    exact, rough = [], []
    for each in report['drives']:
        name = f'{each["family"].replace("_", " ")}, {each["path_m"]:.0f} m'
        on = each['exact']
        ways = ('odometry', 'whole_submap', 'published')
        exact.append([name, *(f'{on[way]["max_m"]:.2f} m' if way in on else '' for way in ways)])
        on = each['rough']
        cells = [_median_and_most(on[way]) if way in on else 'never claimed' for way in ways[1:]]
        rough.append([name, *cells])
    tables = {
        '': markdown_table(
            ['building, path', 'odometry from a right start', 'whole submap', 'published'], exact
        ),
        'rough': markdown_table(['building, path', 'whole submap', 'published'], rough),
    }
    return tables, {}


def _median_and_most(errors: Report) -> str:
    return f'{errors["p50_m"]:.2f} m, {errors["max_m"]:.2f} m'


def carried_off(report: Report) -> Figures:
    """Return what happens to the pose of a robot that is carried off."""
    titles = {
        'asked': 'the walls around the robot are asked',
        'not_asked': 'they are not (`localizer.doubt_probability=1`)',
    }
    rows = [[title, *_carried(report['ways'][way])] for way, title in titles.items()]
    header = ['with', 'localized when lifted', 'withheld', 'after, median and most', 'wrong poses']
    drives = {'drives': str(len(report['drives']))}
    return {'': markdown_table([*header, 'found again', 'right poses'], rows)}, drives


def _carried(way: Report) -> list[str]:
    withheld = [way['withheld_s_median'], way['withheld_s_max']]
    return [
        str(way['localized']),
        str(way['withheld']),
        _seconds(withheld),
        str(way['wrong_poses']),
        str(way['found_again']),
        str(way['right_poses']),
    ]


def _seconds(values: Sequence[float | None]) -> str:
    return ', '.join(f'{value:.1f} s' for value in values if value is not None)
