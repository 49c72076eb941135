# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables and inline figures of the documentation from benchmark reports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
import math

from fpnet_core.errors import ConfigError
from fpnet_lab.evaluation.localization.cases import ROUGH_GROUP
from fpnet_lab.evaluation.localization.peers import peers
from fpnet_lab.evaluation.open_benchmark.scoring import open_figures
from fpnet_lab.evaluation.published import code, rooms, runs, scoring, simulator
from fpnet_lab.evaluation.published.nodes import (
    cloud_transport,
    doctor_faults,
    node_load,
    seeder,
    wirings,
)
from fpnet_lab.evaluation.published.sites import align_pairs, sites
from fpnet_lab.evaluation.published.weights import WEIGHTS
from fpnet_lab.provenance import Provenance
from fpnet_lab.scores import (
    REPORTS,
    Column,
    Figures,
    Row,
    Table,
    Unit,
    Units,
    columns,
    named,
    together,
)

_OPEN_SET = {'wrong_building': "on other buildings' plans", 'mirrored_plan': 'on mirrored plans'}
_PLAIN = ('exact', 'stretched_5', 'stretched_10', 'changed_walls', 'sketch', 'unknown_scale')
# Chosen: aims, in per cent of the sheets of a kind.
_AIMS = {'clean': 98, 'office': 95, 'brochure': 92, 'scan': 90, 'phone': 75}

# Numerical, digits:
_ERROR = (('median_position_error_m', Units.METRES), ('median_yaw_error_deg', Unit('°', 1)))
_HELD = (('nees_mean', Units.NUMBER.to(1)), ('inside_95', Units.SHARE))
_FIRST_POSE = Column(
    'first pose', 'path_to_first_pose_m_median', replace(Units.PATH.to(1, 'none'), whole_from=10)
)
_GROUPS = (
    Column('group', 'name'),
    Column('runs', 'runs'),
    Column('right after 40 m', 'right'),
    _FIRST_POSE,
    Column('wrong poses', 'wrong_published_poses'),
    Column('error', together(*_ERROR)),
    Column('NEES, inside', together(*_HELD)),
    Column('ECE', 'ece', Units.NUMBER),
)

READ_SHARE = replace(Units.SHARE, halves_up=True)
"""Shares of sheets; halves are rounded up."""

SHEETS = (  # numerical: digits
    Column('kind', 'name'),
    Column('sheets', 'sheets'),
    Column('right', 'right', READ_SHARE),
    Column('aim', lambda row: f'{_AIMS[row["name"]]} %' if row['name'] in _AIMS else ''),
    Column('wrong ones doubted', 'wrong_marked', READ_SHARE),
    Column('right ones doubted', 'good_marked', READ_SHARE),
    Column('s', 'seconds_p50', Units.NUMBER.to(1)),
)
"""Columns of the table of sheet kinds."""

_CLAIMS = {
    'right': 'right best',
    'claimed right': 'claimed right',
    'claimed wrong': 'claimed wrong',
    'foreign claimed': 'claimed on the other plan',
}


def published(name: str, report: Row, *made: Provenance) -> dict[str, str]:
    """
    Return the tables and inline figures of a benchmark's report, by name.

    Parameters
    ----------
    name : of the benchmark, one of :data:`MAKERS`
    report : contents of its ``--json`` file, or several reports :func:`joined`
    made : provenance of each report, printed above each table

    Raises
    ------
    ConfigError
        If there is no such benchmark, or the report is not from it.
    """
    tables, values = figures_of(name, report)
    above = '; '.join(dict.fromkeys(map(str, made)))
    texts = {key: f'{above}:\n\n{table.markdown()}\n\n' for key, table in tables.items()} | values
    return {'.'.join(filter(None, (name, key))): text for key, text in texts.items()}


def joined(name: str, reports: Sequence[Row]) -> Row:
    """
    Return the reports of several runs of a benchmark as one report.

    Raises
    ------
    ConfigError
        If there are several reports and the benchmark's tables support one only.
    """
    if len(reports) == 1:
        return reports[0]
    if name not in OF_SEVERAL:
        raise ConfigError(
            f'{len(reports)} reports of {name!r}, whose tables need exactly one; '
            f'several reports are supported for {", ".join(sorted(OF_SEVERAL))}'
        )
    return {REPORTS: list(reports)}


def figures_of(name: str, report: Row) -> Figures:
    """Return tables and inline figures of a benchmark; raises as :func:`published`."""
    if name not in MAKERS:
        raise ConfigError(f'no benchmark {name!r} has tables; choose from {", ".join(MAKERS)}')
    try:
        return MAKERS[name](report)
    except (KeyError, TypeError) as error:
        raise ConfigError(f'no report of {name!r}: it lacks {error}') from error


def _localization(report: Row) -> Figures:
    groups, total = report['groups'], report['total']
    closed = {name: found for name, found in groups.items() if name not in _OPEN_SET}
    runs = sum(found['runs'] for name, found in closed.items() if name != ROUGH_GROUP)
    rows: list[Row] = [{**row, 'right': _right(row)} for row in named(closed, '`{}`')]
    rows += [_open_row(groups[name], title) for name, title in _OPEN_SET.items() if name in groups]
    right = f'{round(total["recall_1m_10deg"] * runs)} of {runs}'
    rows.append({**total, 'name': 'all', 'right': right})
    values = {
        'right': right,
        'plain_right': str(sum(_right(groups[name]) for name in _PLAIN if name in groups)),
        'first_pose': str(_FIRST_POSE.score(total)),
        'wrong_runs': str(total['wrong_published_runs']),
        'false_claims': str(total['open_set_false_claims']),
    }
    return {'': Table.of(_GROUPS, rows)}, values


def _open_row(figures: Row, title: str) -> Row:
    """Return the row of an open-set group: false acceptances and calibration error only."""
    said = {'name': title, 'runs': figures['runs'], 'ece': figures['ece']}
    claims = f'{figures["open_set_false_claims"]} claims'
    return dict.fromkeys([*figures, 'right'], '') | said | {'wrong_published_poses': claims}


def _right(figures: Row) -> int:
    """Return the number of right runs of a group."""
    share, runs = float(figures['recall_1m_10deg']), int(figures['runs'])
    return round(share * runs)


def sheet_rows(report: Row) -> list[Row]:
    """Return the figures of each kind of sheets, then those of all sheets."""
    return list(named({**report['kinds'], 'all': report['all']}))


def _drawings(report: Row) -> Figures:
    scales = {'': report['scale']}
    if 'bormann' in report:
        scales['real_'] = report['bormann']['scale']
    values = {
        f'{which}{key}': READ_SHARE.text(scale[figure])
        for which, scale in scales.items()
        for key, figure in (('scale_within', 'within_10'), ('interval_holds', 'interval_holds'))
    }
    everything, kinds = report['all'], report['kinds']
    values |= {f'{name}_right': READ_SHARE.text(kinds[name]['right']) for name in kinds}
    values |= {
        'right': READ_SHARE.text(everything['right']),
        'wrong': Units.COUNT.text(round((1.0 - everything['right']) * everything['sheets'])),
        'scale_sure': Units.COUNT.text(report['scale']['sure']),
    }
    return {'': Table.of(SHEETS, sheet_rows(report))}, values


def _stated_scales(report: Row) -> Figures:
    ways = {'trusting': 'trusted within the tolerance', 'doubting': 'doubted'}
    nothing = dict.fromkeys(_CLAIMS, 0)
    rows = {
        f'stated {stated}, {said}': nothing | report[f'stated {stated}, {way}']
        for stated, (way, said) in product(('right', 'wrong'), ways.items())
    }
    cases = report['stated right, trusting']['cases']
    cauchy, gaussian = (report['scale'][name]['log_likelihood'] for name in ('Cauchy', 'Gaussian'))
    values = {
        'scatter': Units.NUMBER.to(3).text(report['scale']['Cauchy']['width']),
        'times': Units.COUNT.text(round(math.exp(cauchy - gaussian), -1)),
    }
    titles = [Column(f'{cases} cases each', 'name'), *columns(Units.COUNT, _CLAIMS)]
    return {'': Table.of(titles, named(rows))}, values


MAKERS: dict[str, Callable[[Row], Figures]] = {
    'localization': _localization,
    'peers': peers,
    'open': open_figures,
    **dict.fromkeys(('drawings', 'drawings_pdf', 'drawings_svg', 'drawings_dxf'), _drawings),
    'stated_scales': _stated_scales,
    'demo': runs.demo,
    'real_logs': runs.real_logs,
    'robot': runs.robot,
    'drift': runs.drift,
    'carried_off': runs.carried_off,
    'faults': runs.faults,
    'seeder': seeder,
    'clean_ends': runs.clean_ends,
    'walks': runs.walks,
    'doctor_faults': doctor_faults,
    'short_submaps': runs.short_submaps,
    'guidance': runs.guidance,
    'speed': runs.speed,
    'sites': sites,
    'align_pairs': align_pairs,
    'segmentation': rooms.segmentation,
    **dict.fromkeys(('submaps', 'submaps_3000'), rooms.submaps),
    'scale': rooms.scale,
    **rooms.MATCHES,
    'wirings': wirings,
    **dict.fromkeys(('node_load', 'node_load_kiss'), node_load),
    'cloud_transport': cloud_transport,
    'calibration': scoring.calibration,
    'claim_rules': scoring.claim_rules,
    'scorer_ablation': scoring.scorer_ablation,
    'long_run': runs.long_run,
    'sheet_drives': runs.sheet_drives,
    'two_programs': runs.two_programs,
    'finished_clouds': rooms.finished_clouds,
    'submap_losses': rooms.submap_losses,
    'recordings': simulator.recordings,
    'simulator': simulator.throughput,
    'statistics': simulator.statistics,
    'constants_varied': code.constants_varied,
    'growth': code.growth,
    'readers': code.readers,
    'wheels': code.wheels,
    **WEIGHTS,
}
"""Functions by benchmark name; they return tables and figures keyed by name suffix."""

OF_SEVERAL = frozenset({'constants_varied', 'finished_clouds', 'recordings'})
"""Benchmarks whose tables merge several runs of the command, each of a different part."""
