# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Weights and their manifest are replaced together, or the reader says so."""

from pathlib import Path

import numpy as np
import pytest

from fpnet_core.errors import WeightsError
from fpnet_core.io.weights import read_weights, write_weights

SCHEMA = 3


def write(path, value, **facts):
    write_weights(path, {'layer': np.full(4, value, np.float32)}, SCHEMA, {'network': {}, **facts})


@pytest.fixture
def written(tmp_path):
    path = tmp_path / 'run' / 'weights.safetensors'
    write(path, 1.0)
    return path


def test_what_was_written_is_read(written):
    write(written, 2.0, training={'seed': 4})
    weights = read_weights(written, SCHEMA)
    np.testing.assert_array_equal(weights.tensors['layer'], [2.0] * 4)
    assert weights.manifest['training'] == {'seed': 4}
    assert {path.suffix for path in written.parent.iterdir()} == {'.safetensors', '.json'}


def test_a_manifest_that_cannot_be_written_leaves_both_old_files(written):
    with pytest.raises(TypeError):
        write(written, 2.0, training=object())
    np.testing.assert_array_equal(read_weights(written, SCHEMA).tensors['layer'], [1.0] * 4)
    assert len(list(written.parent.iterdir())) == 2


def test_who_stops_between_both_renames_leaves_what_is_refused(written, monkeypatch):
    rename = Path.replace

    def stop_at_second(self, target):
        if Path(target).suffix == '.safetensors':
            raise KeyboardInterrupt
        return rename(self, target)

    monkeypatch.setattr(Path, 'replace', stop_at_second)
    with pytest.raises(KeyboardInterrupt):
        write(written, 2.0)
    with pytest.raises(WeightsError, match='sha256'):
        read_weights(written, SCHEMA)
