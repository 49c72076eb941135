# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of the figures in the manifests of the packaged weights, their only source."""

from __future__ import annotations

from collections.abc import Callable

from fpnet_lab.scores import Column, Figures, Row, Table, Units, columns, named

# Numerical, digits:
_HUNDREDTH, _TENTH, _IOU = Units.SHARE.to(2), Units.FINE_SHARE, Units.NUMBER
_LOW, _SURE = '0.95', ('0.9', '0.95', '0.97', '0.99')
_TRIALS = {
    'real': 'real maps',
    'drawn': 'drawings made into maps',
    'generated': 'generated maps',
    'drive': 'looks of drives',
    'foreign': 'maps without a plan',
}
_JUDGE = (
    Column('trials', 'name'),
    Column('how many', lambda row: f'{row["trials"]:,.0f}'),
    Column('calibration error', 'ece', Units.NUMBER.to(3)),
    Column('right', 'right', Units.SHARE),
    Column('claimed right', f'claimed_right_{_LOW}', Units.SHARE),
    Column('claimed wrong', f'claimed_wrong_{_LOW}', _HUNDREDTH),
    Column('other plans claimed', f'foreign_claimed_{_LOW}', _HUNDREDTH),
)
_CLAIMS = (
    Column('claims from', 'name'),
    Column('claimed right', 'claimed_right', _TENTH),
    *columns(_HUNDREDTH, {'claimed_wrong': 'claimed wrong', 'foreign_claimed': 'other plans'}),
)
_NO_PLAN = dict.fromkeys(('right', f'claimed_right_{_LOW}', f'claimed_wrong_{_LOW}'))
_DRIVES = {
    'left_out': 'the buildings that it is fitted to, each by a fit without it',
    'other_seed': 'buildings of another seed',
}
_COVARIANCE = (
    Column('drives', 'name'),
    Column('runs', 'runs'),
    Column('mean', 'nees_mean', _IOU.to(1)),
    Column('of the worst run', 'nees_worst_run', _IOU.to(1)),
    Column('inside', 'inside_95', Units.SHARE),
)
_MAPS = {
    'drawings': 'real drawings',
    'bormann': 'of these, those of `bormann`',
    'generated': 'generated drawings',
    'sheets': 'sheets',
    'homes': 'homes',
    'practices': 'small offices',
    'houses': 'houses of large rooms',
    'robot_maps': "robots' maps and drawn ones",
    'generated_maps': 'generated maps',
    'home_maps': 'maps of homes',
}
_SCALE = (
    Column('maps', 'name'),
    Column('n', 'estimates'),
    *columns(Units.SHARE, {'within_10': 'within 10 %', 'held': '90 % interval holds'}),
    Column('high / low', 'spread', _IOU),
)
_DOORS = (
    Column('maps', 'name'),
    Column('n', 'maps'),
    Column('F1 of rooms', 'f1', Units.SHARE),
)
_WALLS = ('outside', 'floor', 'wall', 'door', 'window')
_DOUBTS = (
    Column('readings', 'readings'),
    Column('wrong', 'wrong', Units.SHARE),
    Column('AUC', 'auc', _IOU.to(3)),
    *columns(
        Units.SHARE,
        {
            f'wrong_doubted_at_{share}': f'wrong doubted, with {share * 100:.0f} % of the right'
            for share in (0.03, 0.05, 0.1)
        },
    ),
    Column('pictures of other things', 'others'),
    *columns(
        Units.SHARE,
        {
            'others_known': 'known as such',
            'buildings_taken_for_others': 'buildings taken for such',
        },
    ),
)


def scorer(manifest: Row) -> Figures:
    """Return figures on left-out buildings, and those of real maps by acceptance threshold."""
    found = manifest['figures']
    rows = {title: found[name] for name, title in _TRIALS.items()}
    rows[_TRIALS['foreign']] = {**found['foreign'], **_NO_PLAN}
    real = {
        at: {
            key: found['real'][f'{key}_{at}']
            for key in ('claimed_right', 'claimed_wrong', 'foreign_claimed')
        }
        for at in _SURE
    }
    tables = {'': Table.of(_JUDGE, named(rows)), 'claims': Table.of(_CLAIMS, named(real))}
    return tables, {}


def covariance(manifest: Row) -> Figures:
    """Return the consistency of covariances on buildings that were not used in the fit."""
    rows = {_DRIVES[name]: row for name, row in manifest['held'].items()}
    return {'': Table.of(_COVARIANCE, named(rows))}, {}


def scale(manifest: Row) -> Figures:
    """Return the coverage of scale intervals, with architects left out."""
    rows = {title: manifest['figures'][name] for name, title in _MAPS.items()}
    return {'': Table.of(_SCALE, named(rows))}, {}


def doors(manifest: Row) -> Figures:
    """Return the segmentation accuracy, with buildings left out."""
    return {'': Table.of(_DOORS, named(manifest['figures']))}, {}


def parser(manifest: Row) -> Figures:
    """Return the intersection over union of each class, by kind of sheet."""
    kinds = manifest['figures']['iou']
    rows = {name: row for name, row in kinds.items() if name != 'all'} | {'all': kinds['all']}
    titles = {name: name for name in _WALLS}
    return {'': Table.of([Column('sheets', 'name'), *columns(_IOU, titles)], named(rows))}, {}


def doubts(manifest: Row) -> Figures:
    """Return how many wrong parses get warnings, with buildings left out."""
    return {'': Table.of(_DOUBTS, [manifest['figures']])}, {}


WEIGHTS: dict[str, Callable[[Row], Figures]] = {
    'weights_scorer': scorer,
    'weights_covariance': covariance,
    'weights_scale': scale,
    'weights_doors': doors,
    'weights_parser': parser,
    'weights_doubts': doubts,
}
"""Functions by name of the published table, for the manifests in `fpnet_core/weights`."""
