# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Parser for YAML files from users: plain values only.

Tags never construct objects. Aliases are refused: nested aliases of a few hundred bytes expand to
gigabytes when printed, and neither ROS parameter files nor map_server files use them. All YAML
from outside this package is read here.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import yaml

from fpnet_core.errors import FpnetError
from fpnet_core.plain_files import regular

MAX_BYTES = 1_000_000
"""Numerical: longer files are refused; a configuration or map description is about a page."""


class _PlainLoader(yaml.SafeLoader):
    """PyYAML's safe loader without aliases."""

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Refuse aliases, otherwise compose as usual."""
        if self.check_event(yaml.AliasEvent):
            event = cast('Any', self).peek_event()
            raise yaml.composer.ComposerError(
                None, None, f'alias *{event.anchor} is not supported; write the value out'
            )
        return super().compose_node(parent, index)


def parse_yaml(text: str) -> Any:
    """
    Return the value of a YAML document; None for an empty one.

    Raises
    ------
    ValueError
        If the text is not YAML of plain values; the message is one line.
    """
    try:
        return yaml.load(text, _PlainLoader)  # noqa: S506, it is a safe loader
    except (yaml.YAMLError, ValueError, TypeError, AttributeError, RecursionError) as error:
        # PyYAML's constructors raise the last four for odd scalars and keys.
        raise ValueError(_one_line(error)) from None


def read_yaml(path: Path, refusal: type[FpnetError], what: str = '') -> Any:
    """
    Return the value of a UTF-8 YAML file; None for an empty one.

    Parameters
    ----------
    path : the file
    refusal : class of the error to raise
    what : kind of the file, for the error message

    Raises
    ------
    FpnetError
        ``refusal``, in one line, if the file cannot be read, is too long or is not YAML of plain
        values.
    """
    try:
        return parse_yaml(_text(path))
    except OSError as error:
        named = f'{what} {path}'.lstrip()
        raise refusal(f'cannot read {named}: {error.strerror}') from None
    except ValueError as error:
        raise refusal(f'{path} is not valid YAML: {error}') from None


def _text(path: Path) -> str:
    with regular(path).open('rb') as file:
        content = file.read(MAX_BYTES + 1)
    if len(content) > MAX_BYTES:
        raise ValueError(f'expected at most {MAX_BYTES} bytes, got more')
    try:
        return content.decode('utf-8')
    except UnicodeDecodeError:
        raise ValueError('it is not text in UTF-8') from None


def _one_line(error: Exception) -> str:
    if isinstance(error, RecursionError):
        return 'nested too deeply'
    if isinstance(error, yaml.MarkedYAMLError) and error.problem:
        where = f', line {error.problem_mark.line + 1}' if error.problem_mark else ''
        return f'{error.problem}{where}'
    return (str(error) or type(error).__name__).splitlines()[0]
