# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Results cached on disk, so that an interrupted run resumes where it stopped.

Task names that contain a :func:`digest` keep results of different code versions apart.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, partial
import hashlib
import json
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

import fpnet
import fpnet_core
from fpnet_core.errors import FpnetError
from fpnet_core.io.arrays import read_arrays, write_arrays
from fpnet_core.io.frozen import from_arrays, to_arrays
import fpnet_lab
from fpnet_lab.pool import each_done

Task = TypeVar('Task')
Result = TypeVar('Result')

_COLUMNS = 'columns'  # name of the array that stores the column names of the results
_IRRELEVANT = ('cli', 'viz', 'training')  # folders whose code does not affect any result


def make_once(
    folder: Path | None,
    kind: type[Result],
    tasks: Mapping[str, Task],
    make: Callable[[Task], Result],
    workers: int = 1,
    on_done: Callable[[float], None] = lambda _: None,
    columns: Sequence[str] = (),
    is_kept: Callable[[Result], bool] = lambda _: True,
) -> list[Result]:
    """
    Return the result of ``make`` for each task, in the order of the tasks.

    Parameters
    ----------
    folder : caches each result under its task's name and supplies existing ones; None: no cache
    kind : type of the results: frozen values or tuples of them, see :mod:`fpnet_core.io.frozen`
    tasks : by name
    make : computes one result; with several ``workers`` it runs in that many processes
    on_done : called with 1.0 per finished task; cached tasks count at once
    columns : column names of the result arrays; cached files with other columns are rejected
    is_kept : whether to cache a result for the next run

    Raises
    ------
    FpnetError
        If a cached file is damaged, or of another version.
    """
    results: dict[str, Result] = {}
    for name in tasks:
        path = None if folder is None else _file(folder, name)
        if path is not None and path.exists():
            results[name] = read_kept(path, kind, columns)
            on_done(1.0)
    missing = [(name, task) for name, task in tasks.items() if name not in results]
    for (name, _), result in each_done(partial(_made, make), missing, workers):
        if folder is not None and is_kept(result):
            _write(_file(folder, name), result, columns)
        results[name] = result
        on_done(1.0)
    return [results[name] for name in tasks]


def read_kept(path: Path, kind: type[Result], columns: Sequence[str] = ()) -> Result:
    """
    Return a result cached by :func:`make_once`.

    Raises
    ------
    FpnetError
        If the file is missing, damaged, or of another version.
    """
    try:
        arrays = read_arrays(path)
        if arrays.pop(_COLUMNS, np.array('')).tolist() != list(columns):
            raise ValueError('made with other columns')
        return from_arrays(kind, arrays)
    except (OSError, KeyError, ValueError) as error:
        raise FpnetError(
            f'{path} cannot be resumed from ({error}); remove it, or use another folder'
        ) from None


def digest(content: Any, files: Iterable[Path] = ()) -> str:
    """
    Return a name suffix for a result of ``content`` and ``files`` computed by the current code.

    It also depends on the modules of core and lab and on the packaged weights.

    Parameters
    ----------
    content : plain values, as JSON holds them
    files : further inputs of the result, for example custom weights
    """
    found = hashlib.sha256(_program().encode())
    found.update(json.dumps(content, sort_keys=True).encode())
    for path in files:
        found.update(path.read_bytes())
    return found.hexdigest()[:20]


@cache
def _program() -> str:
    found = hashlib.sha256()
    for package in (fpnet, fpnet_core, fpnet_lab):
        root = Path(package.__path__[0])
        for path in sorted((*root.rglob('*.py'), *root.glob('weights/*.json'))):
            if path.relative_to(root).parts[0] not in _IRRELEVANT:
                found.update(path.read_bytes())
    return found.hexdigest()


def _file(folder: Path, name: str) -> Path:
    return folder / f'{name}.npz'


def _made(make: Callable[[Task], Result], named: tuple[str, Task]) -> Result:
    return make(named[1])


def _write(path: Path, result: object, columns: Sequence[str]) -> None:
    write_arrays(path, to_arrays(result) | {_COLUMNS: np.array(columns, dtype=np.str_)})
