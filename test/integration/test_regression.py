# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The product answers to a few generated drives, pairs of maps and plans as it did before."""

from pathlib import Path

import pytest

from fpnet.cli import main
from fpnet_lab.evaluation import regression

GOLDEN = Path(__file__).resolve().parents[2] / 'benchmarks' / 'regression.json'


@pytest.mark.slow
def test_the_short_form_of_the_regression_set_has_not_changed(capsys):
    with pytest.raises(SystemExit) as ended:
        main(['bench', 'regression', '--short', '--golden', str(GOLDEN)])
    assert ended.value.code in (0, None), capsys.readouterr().out


def test_a_difference_ends_the_command_with_status_1(capsys, monkeypatch):
    plan = {'input': [0, 0], 'rooms': 1, 'doors': 0, 'areas_m2': [1.0]}
    monkeypatch.setattr(regression, 'run_regression', lambda *_: {'plans': {'plans-99': plan}})
    with pytest.raises(SystemExit, match='1'):
        main(['bench', 'regression', '--short', '--golden', str(GOLDEN)])
    assert 'plans-99: new' in capsys.readouterr().out
