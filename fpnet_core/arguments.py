# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Runtime checks of arguments of the Python interface against their annotated types."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import functools
import inspect
import numbers
import reprlib
from types import NoneType, SimpleNamespace, UnionType
from typing import Any, Literal, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

from fpnet_core.errors import FpnetError, said_of_system

Given = ParamSpec('Given')
Returned = TypeVar('Returned')

_NUMBERS = {int: numbers.Integral, float: numbers.Real}  # includes NumPy's scalars


def checked(function: Callable[Given, Returned]) -> Callable[Given, Returned]:
    """
    Wrap a function so that an unusable argument raises FpnetError.

    An argument is unusable if it does not have the annotated type (lists pass for tuples of the
    same length) or if the operating system cannot open the file. Missing and unknown arguments
    still raise Python's TypeError.

    Raises
    ------
    FpnetError
        Raised by the returned function; the message names the argument or the file.
    """
    signature = inspect.signature(function)
    # The return type is skipped: it may be imported for type checkers only.
    annotated = {name: each.annotation for name, each in signature.parameters.items()}
    kinds = get_type_hints(SimpleNamespace(__annotations__=annotated), function.__globals__)

    @functools.wraps(function)
    def called(*args: Given.args, **kwargs: Given.kwargs) -> Returned:
        for name, value in signature.bind(*args, **kwargs).arguments.items():
            if not _is_a(value, kinds[name]):
                raise FpnetError(
                    f'{function.__name__}: {name}: expected {_type_name(kinds[name])}, '
                    f'got {reprlib.repr(value)}'
                )
        try:
            return function(*args, **kwargs)
        except OSError as error:
            raise FpnetError(said_of_system(error)) from error

    return called


def _is_a(value: Any, kind: Any) -> bool:
    """Return whether a value has a type; supports the types used in the interface."""
    parts = get_args(kind)
    if get_origin(kind) in (Union, UnionType):
        return any(_is_a(value, part) for part in parts)
    if get_origin(kind) is Literal:
        return isinstance(value, str) and value in parts
    if parts:
        return _is_filled(value, get_origin(kind), parts)
    if kind in _NUMBERS:
        return isinstance(value, _NUMBERS[kind]) and not isinstance(value, bool)
    return isinstance(value, kind)


def _is_filled(value: Any, container: Any, parts: tuple[Any, ...]) -> bool:
    """Return whether a value is a container whose items have the expected types."""
    if container is dict:
        return isinstance(value, dict) and all(_is_a(key, parts[0]) for key in value)
    if isinstance(value, str | bytes) or not isinstance(value, Sequence):
        return False
    kinds = parts if container is tuple else parts * len(value)
    return len(value) == len(kinds) and all(map(_is_a, value, kinds))


def _type_name(kind: Any) -> str:
    """Return the name of a type for messages."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        return ' or '.join(map(_type_name, parts))
    if origin is Literal:
        return ', '.join(parts)
    if origin is tuple:
        return f'({", ".join(map(_type_name, parts))})'
    if origin is Sequence:
        return f'several {_type_name(*parts)}'
    return 'None' if kind is NoneType else kind.__name__
