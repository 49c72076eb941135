# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of the reports on the placement scorer's probabilities."""

from __future__ import annotations

from fpnet_lab.scores import Column, Figures, Row, Table, Units, named, of, together

_ECE = Units.NUMBER.to(3)  # numerical: digits
_CALIBRATION = (
    Column('trials', 'name'),
    Column('calibration error', 'ece', _ECE),
    Column('right best', 'right_best', Units.SHARE),
    Column('own plans', 'own_trials'),
    Column('claimed', 'claims'),
    Column('wrong', 'wrong_claims'),
    Column('on wrong plans', of('foreign_claims', 'foreign_trials')),
)
_KINDS = {
    'maps': 'generated maps',
    'drives': 'generated drives',
    'real': 'cuts of real pairs, {half} half',
}
_RULES = (  # numerical: digits
    Column('sure looks', 'looks'),
    Column('probability', 'probability', Units.NUMBER),
    Column('more floor', 'news_m2', Units.AREA),
    Column('first claim', 'first_m', Units.PATH),
    Column('never', of('never', 'own')),
    Column('wrong', 'wrong'),
    Column('on other plans', of('foreign_claims', 'foreign')),
)
_SHARES = together(  # numerical: digits
    ('right', Units.SHARE.in_title(0)),
    ('claimed_right', Units.SHARE.in_title(0)),
    ('claimed_wrong', Units.FINE_SHARE),
)


def calibration(report: Row) -> Figures:
    """Return the calibration of stated probabilities, by kind of trials."""
    rows = {
        f'{row["maps"]} {_KINDS[kind].format(half=report["half"])}': row
        for kind, row in report['kinds'].items()
    }
    return {'': Table.of(_CALIBRATION, named(rows | {'all': report}))}, {}


def claim_rules(report: Row) -> Figures:
    """Return the results of each acceptance rule over the updates of recordings."""
    return {'': Table.of(_RULES, report['rules'])}, {'drives': str(report['drives'])}


def scorer_ablation(report: Row) -> Figures:
    """Return a row for each scorer, a column for each band: right, accepted right and wrong."""
    scorers = report['judges']
    bands = list(next(iter(scorers.values())))
    rows = [[name, *(_SHARES(found[band]) for band in bands)] for name, found in scorers.items()]
    return {'': Table(('judge', *bands), rows)}, {}
