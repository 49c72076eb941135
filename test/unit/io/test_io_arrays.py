# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""NumPy files: what goes in comes out, and nothing is executed or reserved for a false header."""

from fuzzing.mutations import MARKER, Payload, lying_npy, npy_bytes
import numpy as np
import pytest

from fpnet_core.io import arrays
from fpnet_core.io.arrays import ArrayArchive, read_array, read_arrays

ARRAYS = [
    np.arange(6.0).reshape(2, 3),
    np.asfortranarray(np.arange(6, dtype='>i4').reshape(2, 3)),
    np.zeros((0, 3)),
    np.array('text'),
    np.array(''),
    np.array([True, False]),
    np.array(7),
    np.array([], dtype=np.str_),
]


@pytest.mark.parametrize('array', ARRAYS, ids=str)
def test_arrays_come_back(tmp_path, array):
    np.save(tmp_path / 'a.npy', array)
    np.savez_compressed(tmp_path / 'a.npz', first=array, second=array)
    found = [read_array(tmp_path / 'a.npy'), *read_arrays(tmp_path / 'a.npz').values()]
    with ArrayArchive(tmp_path / 'a.npz') as archive:
        assert archive.names == ['first', 'second']
        found.append(archive.read('second'))
    for copy in found:
        assert copy.dtype == array.dtype
        assert copy.flags.writeable
        np.testing.assert_array_equal(copy, array)


@pytest.mark.parametrize(
    ('content', 'message'),
    [
        (npy_bytes(np.array([Payload()], dtype=object), allow_pickle=True), 'pickled objects'),
        (lying_npy('<f8', (2**40,), zeros=64), 'needs 8796093022208 bytes, got 64'),
        (lying_npy('<f8', (2**62, 2**62), zeros=64), 'needs'),
        (lying_npy('<f8', (-1,), zeros=64), 'negative shape'),
        (npy_bytes(np.arange(9.0))[:-3], 'needs 72 bytes, got 69'),
        (npy_bytes(np.arange(9.0))[:40], 'not a usable array'),
        (b'\x93NUMPY\x09\x00', 'version'),
        (b'', 'not a usable array'),
        (b'\x93NUMPY\x01\x00\x10\x00' + b"{'descr': (     ", 'not a usable array'),
        (b'PK\x03\x04', 'not a usable array'),
    ],
)
def test_damaged_arrays_are_refused(tmp_path, monkeypatch, content, message):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / 'a.npy'
    path.write_bytes(content)
    with pytest.raises(ValueError, match=message):
        read_array(path)
    assert not (tmp_path / MARKER).exists()


def test_archives_that_unpack_to_more_than_the_limit_are_refused(tmp_path, monkeypatch):
    np.savez_compressed(tmp_path / 'a.npz', a=np.zeros(1000), b=np.zeros(1000))
    monkeypatch.setattr(arrays, 'MAX_BYTES', 10_000)
    with pytest.raises(ValueError, match='unpacks to 16256 bytes, expected at most 10000'):
        read_arrays(tmp_path / 'a.npz')
    with ArrayArchive(tmp_path / 'a.npz') as archive:  # one by one they are small enough
        assert archive.read('b').shape == (1000,)


def test_damaged_archives_are_refused(tmp_path):
    path = tmp_path / 'a.npz'
    np.savez_compressed(path, a=np.random.default_rng(0).random(100))
    good = path.read_bytes()
    for content in (b'', good[:300], good[:100] + bytes(50) + good[150:]):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r'archive|unpacked|usable'):
            read_arrays(path)
    with pytest.raises(OSError, match='directory'):
        read_arrays(tmp_path)
