# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
from functools import cache
import json
import shutil

import numpy as np
import pytest

from fpnet_core.errors import ConfigError
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.pairs import dataset, writing
from fpnet_lab.sim.pairs.dataset import PairDataset
from fpnet_lab.sim.pairs.pair import generate_pair
from fpnet_lab.sim.pairs.writing import refresh_features, write_pairs

SMALL = SimConfig(max_rooms=14, pairs_per_plan=4)


@pytest.fixture(autouse=True)
def _small_blocks(monkeypatch):
    monkeypatch.setattr(writing, 'BLOCK_PAIRS', 2)


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(writing, 'BLOCK_PAIRS', 2)
        path = tmp_path_factory.mktemp('pairs')
        assert write_pairs(path, seed=9, count=4, config=SMALL) == 4
    return path


@cache
def _generated(index):
    return generate_pair(9, index, SMALL)


def _contents(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.glob('pairs-*'))}


def test_blocks_hold_what_was_generated(folder):
    pairs = PairDataset(folder)
    assert len(pairs) == 4
    for index in range(4):
        expected, stored, whole = _generated(index), pairs[index], pairs.pair(index)
        np.testing.assert_array_equal(stored.labels, expected.sub_labels)
        np.testing.assert_array_equal(stored.plan.node_feat, expected.plan_graph.node_feat)
        np.testing.assert_array_equal(stored.sub.edges, expected.sub_graph.edges)
        np.testing.assert_array_equal(whole.sub_graph.edge_feat, expected.sub_graph.edge_feat)
        assert stored.plan_id == 0
        for a, b in zip(whole.plan_graph.regions, expected.plan_graph.regions, strict=True):
            np.testing.assert_array_equal(a.polygon, b.polygon)
            assert (a.label, a.area_m2, a.confidence) == (b.label, b.area_m2, b.confidence)
        for field in ('relations', 'overlap_pairs', 'overlap_m2'):
            np.testing.assert_array_equal(
                getattr(whole.truth, field), getattr(expected.truth, field)
            )


def test_two_workers_write_the_same_bytes_as_one(folder, tmp_path):
    # Workers start with blocks of the default size, so both sides name the sizes themselves.
    assert write_pairs(tmp_path, seed=9, count=4, config=SMALL, workers=2) == 4
    assert _contents(tmp_path) == _contents(folder)


def test_writing_goes_on_where_it_stopped_and_shards_agree(folder, tmp_path):
    done = []
    assert write_pairs(tmp_path, 9, 3, config=SMALL, on_pairs=done.append) == 3
    assert write_pairs(tmp_path, 9, 3, config=SMALL) == 0
    assert write_pairs(tmp_path, 9, 4, config=SMALL, shard=1, num_shards=2) == 2
    assert len(PairDataset(tmp_path)) == 4
    assert sum(done) == 3
    assert _contents(tmp_path).items() >= _contents(folder).items()
    assert json.loads((tmp_path / dataset.MANIFEST).read_text())['count'] == 4


def test_another_seed_or_configuration_is_refused(folder):
    with pytest.raises(ConfigError, match='another seed'):
        write_pairs(folder, 10, 1, config=SMALL)
    with pytest.raises(ConfigError, match='another config'):
        write_pairs(folder, 9, 1, config=SimConfig(max_rooms=15))


def test_a_folder_without_pairs_is_refused(tmp_path):
    with pytest.raises(ConfigError, match='manifest'):
        PairDataset(tmp_path)


def test_old_features_are_refused_until_they_are_computed_anew(tmp_path, monkeypatch):
    write_pairs(tmp_path, 9, 2, config=SMALL)
    before = _contents(tmp_path)
    for module in (dataset, writing):
        monkeypatch.setattr(module, 'FEATURE_SCHEMA', 999)
    monkeypatch.setattr('fpnet_lab.sim.pairs.blocks.FEATURE_SCHEMA', 999)
    with pytest.raises(ConfigError, match='fpnet simulate features'):
        PairDataset(tmp_path)
    assert refresh_features(tmp_path) == 2
    assert refresh_features(tmp_path) == 0
    assert PairDataset(tmp_path).manifest['feature_schema'] == 999
    after = dataset.read_block(next(tmp_path.glob('pairs-*')))
    assert int(after.pop('feature_schema')) == 999
    (tmp_path / next(iter(before))).write_bytes(next(iter(before.values())))
    old = dataset.read_block(next(tmp_path.glob('pairs-*')))
    for name, array in after.items():
        np.testing.assert_array_equal(array, old[name], err_msg=name)


def test_other_layouts_are_refused(folder, tmp_path):
    path = tmp_path / dataset.MANIFEST
    shutil.copy(folder / dataset.MANIFEST, path)
    path.write_text(json.dumps({**json.loads(path.read_text()), 'schema': 1}))
    with pytest.raises(ConfigError, match='schema 1, expected 2'):
        PairDataset(tmp_path)


def test_an_absent_scheduler_is_one_clear_line(tmp_path, monkeypatch):
    pytest.importorskip('distributed')
    monkeypatch.setattr(writing, '_CONNECT_S', 0.5)
    with pytest.raises(ConfigError, match='no Dask scheduler answers at'):
        write_pairs(tmp_path, 9, 1, config=SMALL, cluster='tcp://127.0.0.1:9')
