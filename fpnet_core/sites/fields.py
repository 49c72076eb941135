# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Validation of values in a site's YAML; each error names the file, the field and the fix."""

from __future__ import annotations

from collections.abc import Collection
import math
from pathlib import Path
import reprlib
from typing import Any

from fpnet_core.errors import SiteError
from fpnet_core.plain_yaml import read_yaml


def read_mapping(path: Path) -> dict[str, Any]:
    """Return the mapping in a YAML file; raise SiteError if it is not a mapping."""
    return as_mapping(read_yaml(path, SiteError), str(path))


def as_mapping(value: Any, where: str) -> dict[str, Any]:
    """Return ``value`` if it is a mapping, else raise SiteError."""
    if not isinstance(value, dict):
        raise SiteError(f'{where}: expected a mapping, got {reprlib.repr(value)}')
    return {str(key): each for key, each in value.items()}


def as_list(value: Any, where: str) -> list[Any]:
    """Return ``value`` if it is a list, else raise SiteError."""
    if not isinstance(value, list):
        raise SiteError(f'{where}: expected a list, got {reprlib.repr(value)}')
    return value


def as_numbers(value: Any, count: int, where: str, what: str) -> list[float]:
    """Return the first ``count`` numbers of ``value`` if they are finite, else raise SiteError."""
    try:
        numbers = [float(each) for each in value[:count]]
    except (TypeError, ValueError, KeyError, OverflowError):
        numbers = []
    if len(numbers) < count or not all(map(math.isfinite, numbers)):
        raise SiteError(f'{where}: expected {what}, got {reprlib.repr(value)}')
    return numbers


def as_number(value: Any, where: str, what: str) -> float:
    """Return a finite number, else raise SiteError."""
    try:
        return as_numbers([value], 1, where, what)[0]
    except SiteError:
        raise SiteError(f'{where}: expected {what}, got {reprlib.repr(value)}') from None


def as_whole(value: Any, where: str) -> int:
    """Return an integer, else raise SiteError."""
    number = as_number(value, where, 'a whole number')
    if number != round(number):
        raise SiteError(f'{where}: expected a whole number, got {reprlib.repr(value)}')
    return round(number)


def as_flag(value: Any, where: str) -> bool:
    """Return a bool, else raise SiteError; strings like ``'false'`` are refused."""
    if not isinstance(value, bool):
        raise SiteError(f'{where}: expected true or false, got {reprlib.repr(value)}')
    return value


def as_text(value: Any, where: str, what: str) -> str:
    """Return a non-empty string, else raise SiteError; integers are accepted as names."""
    if isinstance(value, bool) or not isinstance(value, str | int) or not str(value).strip():
        raise SiteError(f'{where}: expected {what}, got {reprlib.repr(value)}')
    return str(value)


def check_keys(values: dict[str, Any], known: Collection[str], where: str) -> None:
    """Raise SiteError if there is an unknown key."""
    if unknown := sorted(set(values) - set(known)):
        raise SiteError(f'{where}: unknown key {unknown[0]!r}; expected one of {", ".join(known)}')
