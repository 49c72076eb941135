# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The comparison of what the product answers with what it answered before."""

from copy import deepcopy
import json

import pytest

from fpnet.cli import main
from fpnet_lab.evaluation.regression import differences

BEFORE = {
    'drives': {
        'drives-00': {
            'input': [1000, 100, 50, 20000],
            'statuses': [['ambiguous', 3], ['localized', 9]],
            'place': [1.0, 2.0, 179.5],
            'off_m': 0.05,
        }
    },
    'pairs': {
        'pairs-00': {
            'input': [1000, 100, 500, 60],
            'status': 'matched',
            'probability': 0.98,
            'places': [[0.0, 0.0], [10.0, 0.0], [0.0, 8.0], [10.0, 8.0]],
            'off_m': 0.1,
        },
        'pairs-01': {
            'input': [1, 1, 1, 1], 'status': 'unmatched', 'probability': 0.2, 'places': None,
        },
    },
    'plans': {'plans-00': {'input': [900, 90], 'rooms': 2, 'doors': 1, 'areas_m2': [20.0, 10.0]}},
}  # fmt: skip


def changed(kind, name, **values):
    found = deepcopy(BEFORE)
    found[kind][name] |= values
    return differences(found, BEFORE)


def test_the_same_answers_differ_in_nothing():
    assert differences(deepcopy(BEFORE), BEFORE) == []
    assert differences({'plans': BEFORE['plans']}, BEFORE) == []


@pytest.mark.parametrize(
    ('kind', 'name', 'values'),
    [
        ('drives', 'drives-00', {'place': [1.05, 2.05, -179.9]}),
        ('drives', 'drives-00', {'statuses': [['ambiguous', 4], ['localized', 8]]}),
        ('drives', 'drives-00', {'off_m': 0.3}),
        ('pairs', 'pairs-00', {'probability': 0.95}),
        ('pairs', 'pairs-01', {'places': BEFORE['pairs']['pairs-00']['places']}),
        ('plans', 'plans-00', {'areas_m2': [20.1, 9.95]}),
        ('plans', 'plans-00', {'input': [900, 90]}),
    ],
)
def test_what_lies_within_the_tolerances_is_the_same(kind, name, values):
    assert changed(kind, name, **values) == []


@pytest.mark.parametrize(
    ('kind', 'name', 'values', 'said'),
    [
        ('drives', 'drives-00', {'place': [1.0, 2.2, 179.5]}, '0.20 m and 0.0 deg elsewhere'),
        ('drives', 'drives-00', {'place': [1.0, 2.0, 177.0]}, '2.5 deg elsewhere'),
        ('drives', 'drives-00', {'place': None}, 'place None'),
        (
            'drives',
            'drives-00',
            {'statuses': [['ambiguous', 5], ['localized', 7]]},
            'ambiguous 5x',
        ),
        (
            'drives',
            'drives-00',
            {'statuses': [['ambiguous', 3], ['localized', 7]]},
            'localized 7x',
        ),
        (
            'drives',
            'drives-00',
            {'statuses': [['ambiguous', 3], ['localized', 8], ['lost', 1]]},
            'lost 1x, were ambiguous 3x, localized 9x',
        ),
        ('pairs', 'pairs-00', {'status': 'ambiguous'}, 'ambiguous, was matched'),
        ('pairs', 'pairs-00', {'probability': 0.9}, 'probability 0.9, was 0.98'),
        ('pairs', 'pairs-00', {'places': None}, 'places None'),
        (
            'pairs',
            'pairs-00',
            {'places': [[0, 0], [10, 0], [0, 8], [10, 8.5]], 'off_m': 0.5},
            'up to 0.50 m elsewhere (0.5 m off, was 0.1 m)',
        ),
        ('plans', 'plans-00', {'rooms': 3, 'areas_m2': [20, 5, 5]}, '3 rooms, were 2'),
        ('plans', 'plans-00', {'doors': 0}, '0 doors, were 1'),
        ('plans', 'plans-00', {'areas_m2': [21.0, 9.0]}, 'areas of rooms [21.0, 9.0]'),
        ('plans', 'plans-00', {'input': [950, 90], 'rooms': 9}, 'the generator has changed'),
    ],
)
def test_what_differs_is_said_in_one_line(kind, name, values, said):
    (line,) = changed(kind, name, **values)
    assert line.startswith(f'{name}: ')
    assert said in line


def test_a_golden_file_that_is_none_is_refused(tmp_path, capsys):
    for name, text in {'a.json': '{', 'b.json': '[1]'}.items():
        (tmp_path / name).write_text(text)
        with pytest.raises(SystemExit, match='1'):
            main(['bench', 'regression', '--golden', str(tmp_path / name)])
        assert 'create it with --write' in capsys.readouterr().err
    (tmp_path / 'c.json').write_text(json.dumps(BEFORE))
    with pytest.raises(SystemExit, match='1'):
        main(['bench', 'regression', '--short', '--write', '--golden', str(tmp_path / 'c.json')])
    assert 'omit --short' in capsys.readouterr().err
