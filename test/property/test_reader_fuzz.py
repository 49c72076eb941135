# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Readers on damaged files: they accept or refuse with a clear message, and execute nothing.

benchmarks/fuzz_readers.py does the same with ten thousand files.
"""

from fuzzing import harness
from fuzzing.harness import GOOD, Case, Outcome, fuzz, plan
from fuzzing.misbehaving import MISBEHAVING
from fuzzing.readers import READERS
import pytest

COUNT = 300
SEED = 1


@pytest.mark.slow
def test_damaged_files_are_refused_with_a_clear_message():
    results = list(fuzz(plan(READERS, COUNT, SEED)))
    assert len(results) == COUNT
    bad = [
        f'{r.case.reader.group} {r.case.reader.name}, input {r.case.index}: {r.outcome} {r.detail}'
        for r in results
        if r.outcome not in GOOD
    ]
    assert bad == []
    assert {result.outcome for result in results} == set(GOOD)


def test_the_harness_notices_what_no_reader_may_do(monkeypatch):
    monkeypatch.setattr(harness, 'TIME_LIMIT_S', 0.5)
    results = list(fuzz([Case(reader, SEED, 0) for reader in MISBEHAVING.values()]))
    found = {result.case.reader: result.outcome for result in results}
    for name, reader in MISBEHAVING.items():
        assert found[reader] == Outcome(name.split()[0]), name


def test_equal_seeds_give_equal_inputs(tmp_path):
    reader = READERS[0]
    (tmp_path / 'valid').mkdir()
    valid = reader.write(tmp_path / 'valid')
    paths = [
        harness.make_input(Case(reader, seed, 3), valid, tmp_path / name)
        for name, seed in (('a', 0), ('b', 0), ('c', 1))
    ]
    first, second, third = (path.read_bytes() for path in paths)
    assert first == second != third
