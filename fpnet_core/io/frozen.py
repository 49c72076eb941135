# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Conversion of frozen values (trees of dataclasses) to a few plain arrays, and back.

Values are built from the type annotations of the requested class. New fields need no change here,
and a file cannot name a class to be built.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
import json
from types import NoneType, UnionType
from typing import Any, ClassVar, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

Value = TypeVar('Value')
Arrays = dict[str, NDArray[Any]]

_TREE = 'tree'  # name of the array that holds everything but arrays, as JSON


def to_arrays(value: object) -> Arrays:
    """
    Return a frozen value as arrays: one per element type, and one of text with the structure.

    Raises
    ------
    TypeError
        If it contains anything but dataclasses, enumerations, tuples, mappings with text keys,
        arrays of plain elements, numbers, text, True, False and None.
    """
    leaves: dict[str, list[NDArray[Any]]] = {}
    tree = json.dumps(_plain(value, leaves))
    joined = {name: np.concatenate([x.ravel() for x in each]) for name, each in leaves.items()}
    return {_TREE: np.array(tree), **joined}


def from_arrays(kind: type[Value], arrays: Arrays) -> Value:
    """
    Return the value of type ``kind`` that was converted by :func:`to_arrays`.

    Missing fields, as in files of older versions, get their defaults.

    Raises
    ------
    ValueError
        If the arrays do not describe such a value.
    """
    try:
        return _Builder(arrays).build(kind, json.loads(str(arrays[_TREE])))  # type: ignore[no-any-return]
    except (KeyError, TypeError, IndexError, AttributeError, OverflowError) as error:
        raise ValueError(f'does not describe a {kind.__name__}: {error!r}') from None


def _plain(value: Any, leaves: dict[str, list[NDArray[Any]]]) -> Any:
    if is_dataclass(value):
        return {f.name: _plain(getattr(value, f.name), leaves) for f in fields(value)}
    match value:
        case np.ndarray():
            plain: Any = _stored(value, leaves)
        case Enum():
            plain = value.value
        case tuple():
            plain = [_plain(entry, leaves) for entry in value]
        case dict():
            plain = {key: _plain(entry, leaves) for key, entry in value.items()}
        case np.generic():
            plain = value.item()
        case None | bool() | int() | float() | str():
            plain = value
        case _:
            raise TypeError(f'{type(value).__name__} cannot be stored')
    return plain


def _stored(array: NDArray[Any], leaves: dict[str, list[NDArray[Any]]]) -> list[Any]:
    if array.dtype.hasobject:
        raise TypeError('arrays of objects cannot be stored')
    name = array.dtype.str.lstrip('<>|=')
    leaves.setdefault(name, []).append(array)
    return [name, list(array.shape)]


@cache
def _hints(kind: type[Any]) -> dict[str, Any]:
    return get_type_hints(kind)


class _Builder:
    """Builds values; takes their arrays from the stored ones in order."""

    def __init__(self, arrays: Arrays) -> None:
        self._arrays = arrays
        self._used: dict[str, int] = {}

    def build(self, kind: Any, plain: Any) -> Any:
        """Return the value for annotation ``kind``."""
        if is_dataclass(kind):
            return self._build_fields(kind, plain)
        builder = self._BUILDERS.get(get_origin(kind))
        return kind(plain) if builder is None else builder(self, get_args(kind), plain)

    def _build_fields(self, kind: Any, plain: dict[str, Any]) -> Any:
        """Build fields in the file's order, which is the order of the stored arrays."""
        hints = _hints(kind)
        return kind(**{name: self.build(hints[name], entry) for name, entry in plain.items()})

    def _build_optional(self, choices: tuple[Any, ...], plain: Any) -> Any:
        [inner] = [choice for choice in choices if choice is not NoneType]
        return None if plain is None else self.build(inner, plain)

    def _build_tuple(self, inner: tuple[Any, ...], plain: list[Any]) -> tuple[Any, ...]:
        kinds = inner[:1] * len(plain) if inner[1:] == (Ellipsis,) else inner
        return tuple(self.build(kind, entry) for kind, entry in zip(kinds, plain, strict=True))

    def _build_mapping(self, inner: tuple[Any, ...], plain: dict[str, Any]) -> dict[str, Any]:
        return {str(key): self.build(inner[1], entry) for key, entry in plain.items()}

    def _build_choice(self, choices: tuple[Any, ...], plain: Any) -> Any:
        return choices[choices.index(plain)]

    def _build_array(self, _: tuple[Any, ...], plain: list[Any]) -> NDArray[Any]:
        return self._take(*plain)

    def _take(self, name: str, shape: list[int]) -> NDArray[Any]:
        start = self._used.get(name, 0)
        count = int(np.prod(shape, dtype=object)) if shape else 1
        if count < 0 or start + count > len(self._arrays[name]):
            raise ValueError(f'shape {shape} of {name} exceeds the stored data')
        self._used[name] = start + count
        return self._arrays[name][start : start + count].reshape(shape)

    _BUILDERS: ClassVar[dict[Any, Callable[[_Builder, tuple[Any, ...], Any], Any]]] = {
        Union: _build_optional,
        UnionType: _build_optional,
        tuple: _build_tuple,
        dict: _build_mapping,
        Literal: _build_choice,
        np.ndarray: _build_array,
    }
