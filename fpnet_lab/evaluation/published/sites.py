# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of ``fpnet bench sites``."""

from __future__ import annotations

from fpnet_lab.scores import Column, Figures, Row, Table, Unit, Units, columns, named

_KINDS = {
    'apart': 'storeys differ by 10 % of their walls or more',
    'equal': 'two storeys are equal',
}
_STOREYS = (  # numerical: digits
    Column('sites of 2 to 12 storeys', 'name'),
    Column('drives', 'sites'),
    Column('right after 40 m', 'right'),
    Column('wrong storey claimed', 'wrong_storeys'),
    Column('first claim', 'path_m_median', Units.PATH),
    Column('on one plan', 'path_alone_m_median', Units.PATH),
    Column('a wall that differs seen', 'parted_m_median', Units.PATH),
    *columns(Units.MS, {'tick_ms_mean': 'tick, median', 'tick_alone_ms_mean': 'on one plan'}),
    Column('with 12 storeys', 'tick_ratio_12', Unit(' times', 1)),
)
_ONE = (  # numerical: digits
    Column('the same drive', 'name'),
    *columns(Units.MS.to(2), {'': 'on the floorplan', '_site': 'on a site of it alone'}),
    Column('ratio, median', '_ratio', Units.NUMBER.to(3)),
    Column('its quartiles apart', '_ratio_spread', Units.NUMBER.to(3)),
)
_DIFFERENCES = (  # numerical: digits
    *columns(Units.SHARE, {'precision': 'precision', 'recall': 'recall where seen'}),
    Column('furniture taken for wall', 'furniture_as_wall', Units.SHARE),
    Column('false ones on exact drawings', 'false_per_100_m', Unit(' per 100 m of wall', 1)),
    *columns(Units.COUNT, {'pieces': 'found', 'true_pieces': 'there'}),
)
_FIRST_10 = Column('among the first 10', 'in_first_10', Units.SHARE)
_QUERY = Column('query, median', 'query_ms_median', Units.MS)
_LIBRARY = (
    Column('seen', 'name'),
    Column('asked', 'cases'),
    Column('first', 'first', Units.SHARE),
    _FIRST_10,
    _QUERY,
)
_GROWTH = (
    Column('plans', lambda row: f'{row["plans"]:,}'),
    Column('index', 'megabytes', Unit(' MB')),
    _QUERY,
    _FIRST_10,
)


_ALIGNED = (  # numerical: digits
    Column('robot map and plan', 'name'),
    Column('wall', 'walls_m', Unit(' m')),
    Column('median', 'median_m', Units.METRES.to(2, '-')),
    Column('90 %', 'p90_m', Units.METRES.to(2, '-')),
    Column('explained', 'explained', Units.SHARE),
    Column('off', 'error_m', Units.METRES.to(2, '-')),
    Column('at most', 'worst_m', Units.METRES.to(2, '-')),
    Column('stated sigma', 'sigma_m', Units.METRES.to(2, '-')),
    Column('exported map placed again', 'back_m', Units.METRES.to(2, '-')),
    Column('Open-RMF layer', 'rmf_m', Units.METRES.to(2, '-')),
)


def align_pairs(report: Row) -> Figures:
    """Return the table of robot maps aligned with their plans."""
    pairs = report['pairs']
    aligned = {name: row for name, row in pairs.items() if row['status'] == 'aligned'}
    values = {'aligned': f'{len(aligned)} of {len(pairs)}'}
    return {'': Table.of(_ALIGNED, named(aligned))}, values


def sites(report: Row) -> Figures:
    """Return the tables of storeys, differences and libraries that the report contains."""
    tables = {}
    if 'sites' in report:
        tables[''] = Table.of(_STOREYS, _storeys(report['sites']))
    if 'one' in report:
        tables['one'] = _one(report['one'])
    if 'differences' in report:
        tables['differences'] = Table.of(_DIFFERENCES, [report['differences']])
    if 'library' in report:
        tables['library'] = _library(report['library'])
        tables['growth'] = Table.of(_GROWTH, report['library']['growth'])
    return tables, {}


def _storeys(part: Row) -> list[Row]:
    """Return rows of the existing kinds; equal storeys have no right answer, only ambiguity."""
    rows = {title: {**part[name]} for name, title in _KINDS.items() if part[name]['sites']}
    if _KINDS['equal'] in rows:
        rows[_KINDS['equal']]['right'] = f'ambiguous {part["equal"]["ambiguous"]}'
    return list(named(rows))


def _one(row: Row) -> Table:
    rows = {
        title: {key.removeprefix(part): value for key, value in row.items() if part in key}
        for title, part in (('tick, median', 'tick_ms'), ('adding a scan, median', 'scan_ms'))
    }
    said = f'Poses are equal to the last bit on {row["same"]} of {row["drives"]} drives.'
    return Table.of(_ONE, named(rows), said)


def _library(part: Row) -> Table:
    right, wrong = (part['claims'][what] for what in ('right', 'wrong'))
    said = (
        f'{part["plans"]} plans, {part["kilobytes_a_plan"]:.1f} kB each. After a search of the '
        f'first 10, {Units.SHARE.text(right)} of the drives are claimed right and '
        f'{Units.FINE_SHARE.text(wrong)} wrong.'
    )
    return Table.of(_LIBRARY, named(part['groups']), said)
