# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Results that are kept as they come, so that an interrupted run goes on where it stopped.

Figures of two versions are never mixed where the names of their tasks hold a :func:`digest`.
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

_COLUMNS = 'columns'  # name of the array with what the columns of the results mean
_IRRELEVANT = ('cli', 'viz', 'training')  # folders whose text changes no figure


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
    Return what ``make`` makes of each task, in their order.

    Parameters
    ----------
    folder : keeps each result under its task's name, and gives those that it has; None keeps none
    kind : of the results: frozen values, or tuples of such, as :mod:`fpnet_core.io.frozen` stores
    tasks : by name
    make : of one task; with several ``workers``, in one of so many processes
    on_done : is told 1.0 for each task, those at once that were made before
    columns : what the columns of arrays in the results mean; files with others are refused
    is_kept : whether a result may be taken the next time, too

    Raises
    ------
    FpnetError
        If a kept file is damaged, or of another version.
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
    Return a result that :func:`make_once` has kept.

    Raises
    ------
    FpnetError
        If there is none, or it is damaged, or of another version.
    """
    try:
        arrays = read_arrays(path)
        if arrays.pop(_COLUMNS, np.array('')).tolist() != list(columns):
            raise ValueError('made with other columns')
        return from_arrays(kind, arrays)
    except (OSError, KeyError, ValueError) as error:
        raise FpnetError(
            f'{path} cannot be gone on with ({error}); remove it, or use another folder'
        ) from None


def digest(content: Any, files: Iterable[Path] = ()) -> str:
    """
    Return a name's end for a result of ``content`` and ``files`` by the program as it is now.

    It changes with the modules of core and lab and with the weights that ship, too.

    Parameters
    ----------
    content : plain values, as JSON holds them
    files : what else the result depends on, as weights of one's own
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
