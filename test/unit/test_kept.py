# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Results that are kept as they come."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import pytest

from fpnet_core.errors import FpnetError
from fpnet_lab.kept import digest, make_once, read_kept


@dataclass(frozen=True, eq=False)
class Square:
    side: int
    table: NDArray[np.int16]


class Interrupted(Exception):
    pass


def square(side):
    if side < 0:
        raise Interrupted
    return Square(side, np.full((side, 2), side, dtype=np.int16))


def unmade(_):
    raise AssertionError('made again')


TASKS = {'three': 3, 'one': 1, 'two': 2}


def sides(folder, make=square, tasks=None, **more):
    return [each.side for each in make_once(folder, Square, tasks or TASKS, make, **more)]


def test_what_was_made_is_taken_over_in_the_order_of_the_tasks(tmp_path):
    done = []
    with pytest.raises(Interrupted):
        sides(tmp_path, tasks={'three': 3, 'no': -1, 'one': 1}, on_done=done.append)
    assert done == [1.0]
    assert [path.name for path in tmp_path.iterdir()] == ['three.npz']
    made = []
    again = sides(tmp_path, lambda side: made.append(side) or square(side), on_done=done.append)
    assert again == [3, 1, 2]
    assert made == [1, 2]
    assert done == [1.0] * 4
    assert sides(tmp_path, unmade) == [3, 1, 2]


def test_several_processes_give_the_same(tmp_path):
    assert sides(tmp_path, workers=2) == [3, 1, 2]
    assert sides(tmp_path, unmade) == [3, 1, 2]


def test_nothing_is_kept_without_a_folder_or_where_it_may_not_be(tmp_path):
    assert sides(None) == [3, 1, 2]
    sides(tmp_path, is_kept=lambda each: each.side != 1)
    assert sorted(path.stem for path in tmp_path.iterdir()) == ['three', 'two']


def test_files_that_are_damaged_or_of_other_columns_are_refused(tmp_path):
    make_once(tmp_path, Square, TASKS, square, columns=['x', 'y'])
    with pytest.raises(FpnetError, match=r'one\.npz.*other columns.*another folder'):
        read_kept(tmp_path / 'one.npz', Square, ['y', 'x'])
    (tmp_path / 'one.npz').write_bytes(b'PK')
    with pytest.raises(FpnetError, match=r'one\.npz cannot be resumed from'):
        sides(tmp_path, columns=['x', 'y'])


def test_a_digest_is_of_content_and_files(tmp_path):
    weights = tmp_path / 'weights'
    weights.write_bytes(b'1')
    first = digest({'a': 1, 'b': 2}, [weights])
    assert first == digest({'b': 2, 'a': 1}, [weights])
    assert len({first, digest({'a': 2, 'b': 2}, [weights]), digest({'a': 1, 'b': 2})}) == 3
    weights.write_bytes(b'2')
    assert digest({'a': 1, 'b': 2}, [weights]) != first
