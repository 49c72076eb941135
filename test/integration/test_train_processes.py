# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Training by several processes under torchrun, and of what judges the network's answers alone."""

import csv
import os
from pathlib import Path
import subprocess
import sys

import pytest

from fpnet.cli import main
from fpnet_core.io.weights import read_weights
from fpnet_core.types import FEATURE_SCHEMA
from fpnet_lab.evaluation.pair_sets import SEED
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.pairs.writing import write_pairs

BIN = Path(sys.executable).parent
SMALL = ('network.width=8', 'network.layers=1', 'batch_size=2', 'validation_fraction=0.3')


@pytest.fixture(scope='module')
def pairs(tmp_path_factory):
    folder = tmp_path_factory.mktemp('pairs')
    config = SimConfig(robot_map='clip', max_rooms=14)
    write_pairs(folder, seed=3, count=24, config=config)
    return folder


def train(pairs, out, *prefix):
    settings = [word for setting in SMALL for word in ('--set', setting)]
    words = ['fpnet', 'train', 'matcher', '--data', pairs, '--out', out]
    words += ['--epochs', '2', *settings]
    environment = os.environ | {'OMP_NUM_THREADS': '1', 'PATH': f'{BIN}:{os.environ["PATH"]}'}
    return subprocess.run(
        [*map(str, prefix), *map(str, words)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )


def test_two_processes_make_one_run(pairs, tmp_path):
    out = tmp_path / 'run'
    launcher = (BIN / 'torchrun', '--nproc-per-node', '2', '--no-python')

    result = train(pairs, out, *launcher)

    assert result.returncode == 0, result.stderr
    assert result.stdout.count('held back') == 1
    rows = list(csv.DictReader((out / 'curves.csv').open()))
    assert [row['epoch'] for row in rows] == ['0', '1']
    assert list((out / 'tensorboard').glob('events.*'))
    weights = read_weights(out / 'matcher.safetensors', FEATURE_SCHEMA)
    assert weights.manifest['training']['config']['batch_size'] == 2


def test_evidence_is_fitted_anew_and_the_network_stays(pairs, tmp_path):
    words = ['train', 'evidence', '--data', str(pairs), '--out', str(tmp_path / 'run')]

    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 0

    made = read_weights(tmp_path / 'run' / 'matcher.safetensors', FEATURE_SCHEMA)
    packaged = read_weights(None, FEATURE_SCHEMA)
    assert made.tensors.keys() == packaged.tensors.keys()
    assert all((made.tensors[name] == packaged.tensors[name]).all() for name in made.tensors)
    assert made.manifest['training'] == packaged.manifest['training']
    assert made.manifest['evidence'] != packaged.manifest['evidence']
    assert made.manifest['evidence_data'][pairs.name]['seed'] == 3
    # What is packaged comes from four such folders, and from none of the benchmark's seed.
    sets = packaged.manifest['evidence_data']
    assert set(sets) == {'tours', 'challenging', 'real', 'synthetic'}
    assert {each['seed'] for each in sets.values()}.isdisjoint({SEED})
