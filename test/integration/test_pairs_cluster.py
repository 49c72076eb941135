# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import pytest

from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.pairs import writing
from fpnet_lab.sim.pairs.writing import write_pairs

SMALL = SimConfig(max_rooms=14)
COUNT = 5


def _contents(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.glob('pairs-*'))}


def test_a_cluster_of_two_writes_the_same_bytes_as_one_process(tmp_path, monkeypatch):
    monkeypatch.setattr(writing, 'BLOCK_PAIRS', 2)
    distributed = pytest.importorskip('distributed')
    done = []
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, worker_dashboard_address=None
    ) as cluster:
        write_pairs(
            tmp_path / 'cluster',
            seed=4,
            count=COUNT,
            config=SMALL,
            on_pairs=done.append,
            cluster=cluster.scheduler_address,
        )
    assert sum(done) == COUNT
    write_pairs(tmp_path / 'alone', seed=4, count=COUNT, config=SMALL)
    assert len(_contents(tmp_path / 'alone')) == 3
    assert _contents(tmp_path / 'cluster') == _contents(tmp_path / 'alone')
