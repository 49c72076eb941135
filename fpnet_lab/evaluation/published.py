# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports of benchmarks to the tables and figures that the documentation shows of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product
import math
from typing import Any

from fpnet_core.errors import ConfigError
from fpnet_lab.evaluation import published_runs as runs
from fpnet_lab.evaluation.figures import markdown_table
from fpnet_lab.evaluation.localization.cases import ROUGH_GROUP
from fpnet_lab.evaluation.localization.peers import COLUMNS, MAP_COLUMNS, map_rows, peer_rows
from fpnet_lab.evaluation.published_sites import sites
from fpnet_lab.provenance import Provenance

Report = Mapping[str, Any]

_OPEN_SET = {'wrong_building': "on other buildings' plans", 'mirrored_plan': 'on mirrored plans'}
_PLAIN = ('exact', 'stretched_5', 'stretched_10', 'changed_walls', 'sketch', 'unknown_scale')
# Chosen: what the aims are, in per cent of the sheets of a kind.
_AIMS = {'clean': 98, 'office': 95, 'brochure': 92, 'scan': 90, 'phone': 75}
_WHOLE_M = 10.0  # numerical: lengths from here on are given in whole metres


def published(name: str, report: Report, made: Provenance) -> dict[str, str]:
    """
    Return the tables and figures that a benchmark's report gives, by name.

    Parameters
    ----------
    name : of the benchmark, one of :data:`MAKERS`
    report : what its ``--json`` has written
    made : stands above each table

    Raises
    ------
    ConfigError
        If there is no such benchmark, or the report is none of it.
    """
    if name not in MAKERS:
        raise ConfigError(f'no figures of {name!r} are published; choose of {", ".join(MAKERS)}')
    try:
        tables, values = MAKERS[name](report)
    except (KeyError, TypeError) as error:
        raise ConfigError(f'no report of {name!r}: {error} is missing in it') from error
    texts = {key: f'{made}:\n\n{table}\n\n' for key, table in tables.items()} | values
    return {'.'.join(filter(None, (name, key))): text for key, text in texts.items()}


def _localization(report: Report) -> tuple[dict[str, str], dict[str, str]]:
    groups, total = report['groups'], report['total']
    closed = [name for name in groups if name not in _OPEN_SET]
    runs = sum(groups[name]['runs'] for name in closed if name != ROUGH_GROUP)
    rows = [_closed_row(f'`{name}`', groups[name]) for name in closed]
    rows += [_open_row(title, groups[name]) for name, title in _OPEN_SET.items() if name in groups]
    whole = _closed_row('all', total)
    right = round(total['recall_1m_10deg'] * runs)
    whole[2] = f'{right} of {runs}'
    header = ['group', 'runs', 'right after 40 m', 'first pose', 'wrong poses', 'error']
    header += ['NEES, inside', 'ECE']
    plain = [groups[name] for name in _PLAIN if name in groups]
    values = {
        'right': whole[2],
        'plain_right': str(sum(map(_right, plain))),
        'first_pose': whole[3],
        'wrong_runs': str(total['wrong_published_runs']),
        'false_claims': str(total['open_set_false_claims']),
    }
    return {'': markdown_table(header, [*rows, whole])}, values


def _open_row(title: str, figures: Report) -> list[str]:
    return [title, str(figures['runs']), '', '', _claims(figures), '', '', _ece(figures)]


def _closed_row(title: str, figures: Report) -> list[str]:
    metres, degrees = figures['median_position_error_m'], figures['median_yaw_error_deg']
    return [
        title,
        str(figures['runs']),
        str(_right(figures)),
        _metres(figures['path_to_first_pose_m_median']),
        str(figures['wrong_published_poses']),
        '' if metres is None else f'{metres:.2f} m, {degrees:.1f}°',
        _held(figures),
        _ece(figures),
    ]


def _right(figures: Report) -> int:
    """Return how many runs of a group with a right answer were right."""
    share, runs = float(figures['recall_1m_10deg']), int(figures['runs'])
    return round(share * runs)


def _claims(figures: Report) -> str:
    return f'{figures["open_set_false_claims"]} claims'


def _held(figures: Report) -> str:
    """Return the normalised squared error and the share inside of the 95 % gate."""
    mean, inside = figures['nees_mean'], figures['inside_95']
    return '' if mean is None else f'{mean:.1f}, {100.0 * inside:.0f} %'


def _ece(figures: Report) -> str:
    return '' if figures['ece'] is None else f'{figures["ece"]:.2f}'


def _metres(value: float | None) -> str:
    if value is None:
        return 'none'
    return f'{value:.1f} m' if value < _WHOLE_M else f'{value:.0f} m'


def _peers(report: Report) -> tuple[dict[str, str], dict[str, str]]:
    tables = {'': markdown_table(list(COLUMNS), peer_rows(report['methods']))}
    if 'maps' in report:
        tables['maps'] = markdown_table(list(MAP_COLUMNS), map_rows(report['maps']))
    return tables, {}


def _drawings(report: Report) -> tuple[dict[str, str], dict[str, str]]:
    header = ['kind', 'sheets', 'right', 'aim', 'wrong ones doubted', 'right ones doubted', 's']
    rows = [
        [
            name,
            str(figures['sheets']),
            _per_cent(figures['right']),
            f'{_AIMS[name]} %' if name in _AIMS else '',
            _per_cent(figures['wrong_marked']),
            _per_cent(figures['good_marked']),
            f'{figures["seconds_p50"]:.1f}',
        ]
        for name, figures in {**report['kinds'], 'all': report['all']}.items()
    ]
    scales = {'': report['scale']}
    if 'bormann' in report:
        scales['real_'] = report['bormann']['scale']
    values = {
        f'{which}{key}': _per_cent(scale[figure])
        for which, scale in scales.items()
        for key, figure in (('scale_within', 'within_10'), ('interval_holds', 'interval_holds'))
    }
    everything = report['all']
    values |= {f'{name}_right': _per_cent(each['right']) for name, each in report['kinds'].items()}
    values |= {
        'right': _per_cent(everything['right']),
        'wrong': str(round((1.0 - everything['right']) * everything['sheets'])),
        'scale_sure': str(report['scale']['sure']),
    }
    return {'': markdown_table(header, rows)}, values


def _stated_scales(report: Report) -> tuple[dict[str, str], dict[str, str]]:
    ways = {'trusting': 'trusted within the tolerance', 'doubting': 'doubted'}
    keys = ('right', 'claimed right', 'claimed wrong', 'foreign claimed')
    rows = []
    for stated, way in product(('right', 'wrong'), ways):
        counts = report[f'stated {stated}, {way}']
        rows.append([f'stated {stated}, {ways[way]}', *(str(counts.get(key, 0)) for key in keys)])
    cases = report['stated right, trusting']['cases']
    header = [f'{cases} cases each', 'right best', 'claimed right', 'claimed wrong']
    cauchy, gaussian = (report['scale'][name]['log_likelihood'] for name in ('Cauchy', 'Gaussian'))
    values = {
        'scatter': f'{report["scale"]["Cauchy"]["width"]:.3f}',
        'times': f'{round(math.exp(cauchy - gaussian), -1):.0f}',
    }
    return {'': markdown_table([*header, 'claimed on the other plan'], rows)}, values


def _per_cent(value: float | None) -> str:
    """Return a share in per cent, halves rounded up as people do."""
    return '' if value is None else f'{math.floor(100.0 * value + 0.5)} %'


MAKERS: dict[str, Callable[[Report], tuple[dict[str, str], dict[str, str]]]] = {
    'localization': _localization,
    'peers': _peers,
    'drawings': _drawings,
    'drawings_pdf': _drawings,
    'drawings_svg': _drawings,
    'drawings_dxf': _drawings,
    'stated_scales': _stated_scales,
    'demo': runs.demo,
    'real_logs': runs.real_logs,
    'robot': runs.robot,
    'drift': runs.drift,
    'carried_off': runs.carried_off,
    'sites': sites,
}
"""For each benchmark: its report to tables and figures, by the rest of their names."""
