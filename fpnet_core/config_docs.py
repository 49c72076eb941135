# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The configuration tree as a flat, documented list of keys.

The documented ``config/fpnet.yaml`` and the nodes' parameter declarations both come from here.
``python -m fpnet_core.config_docs`` prints the YAML file, with ``markdown`` the reference page.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
import re
import sys
from textwrap import wrap
import types
from typing import Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo
import yaml

from fpnet_core.config import FpnetConfig, Section

_COMMENT_WIDTH = 96  # numerical
_BOUNDS = ('ge', 'gt', 'le', 'lt')
_UNITS = {'m': 'm', 'm2': 'm²', 's': 's', 'rad': 'rad', 'mps': 'm/s'}  # by the name's last word

_HEADER = """\
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
#
# Every key of the configuration. The nodes take this file with
#   ros2 run fpnet_ros localizer --ros-args --params-file fpnet.yaml
# and the command line with fpnet localize --config fpnet.yaml; keys may be left out.
# Generated from the configuration tree by python -m fpnet_core.config_docs.
"""


_PAGE_HEADER = """\
# Parameters

Every key of the configuration, for the command line (`--config FILE`, `--set KEY=VALUE`) and, with
the same names, for the [nodes](ros.md#parameters) that use it.
`config/fpnet.yaml` is this list with the defaults, as a file to change. Unknown keys and
values out of range are errors.

This page is generated: `python -m fpnet_core.config_docs markdown > docs/parameters.md`.
"""
_FIRST = {
    'submap.sensor_height_m': 'where a scanner is mounted, until it sees a floor',
    'submap.max_range_m': 'how far its returns can be trusted',
    'localizer.scale_policy': 'whether the scale of the plan is trusted, about right or unknown',
    'localizer.tick_period_s': 'how often the robot looks where it is',
    'localizer.claim_probability': 'how sure it has to be to say so',
}
_COLUMNS = ('key', 'type', 'unit', 'range', 'default', 'what it does')


@dataclass(frozen=True)
class ConfigField:
    """
    One key of the tree.

    ``kind`` is bool, int, float or str, of the elements where ``is_list``; ``bounds`` maps
    ``ge gt le lt`` to numbers; ``choices`` are the accepted strings, empty if any is.
    """

    key: str
    kind: type
    default: Any
    description: str
    bounds: dict[str, float]
    choices: tuple[str, ...] = ()
    is_list: bool = False

    @property
    def constraint(self) -> str:
        """The accepted values in words, empty if all are."""
        if self.choices:
            return 'one of ' + ', '.join(self.choices)
        signs = {'ge': '>=', 'gt': '>', 'le': '<=', 'lt': '<'}
        return ', '.join(f'{signs[name]} {value:g}' for name, value in self.bounds.items())

    @property
    def unit(self) -> str:
        """The unit that the description or the name's end says; empty: a pure number or text."""
        if stated := re.search(r'\[(.+?)\]', self.description):
            return stated[1]
        return _UNITS.get(self.key.rpartition('.')[2].rpartition('_')[2], '')


def config_fields(section: type[Section] = FpnetConfig, prefix: str = '') -> Iterator[ConfigField]:
    """Yield every key below ``section`` in the order of declaration, dotted from ``prefix``."""
    for name, info in section.model_fields.items():
        key = f'{prefix}{name}'
        if isinstance(info.annotation, type) and issubclass(info.annotation, Section):
            yield from config_fields(info.annotation, f'{key}.')
        else:
            yield _leaf(key, info)


def render_yaml(config: FpnetConfig | None = None) -> str:
    """Return the documented ROS parameter file of ``config``; None takes the defaults."""
    lines = [_HEADER, '/**:', '  ros__parameters:']
    lines += _render_section(FpnetConfig, config or FpnetConfig(), '    ')
    return '\n'.join(lines) + '\n'


def render_markdown() -> str:
    """Return the reference page of the whole tree, one table for each section."""
    sections: dict[str, list[ConfigField]] = {}
    for field in config_fields():
        sections.setdefault(field.key.rpartition('.')[0], []).append(field)
    parts = [_PAGE_HEADER, _first_keys(sections)]
    for name, fields in sections.items():
        parts.append(f'## {name or "Top level"}\n\n{_section_summary(name)}\n')
        rows = [_COLUMNS, ('---',) * len(_COLUMNS), *map(_table_row, fields)]
        parts.append('\n'.join(f'| {" | ".join(row)} |' for row in rows) + '\n')
    return '\n'.join(parts)


def _first_keys(sections: dict[str, list[ConfigField]]) -> str:
    """Return the table of the keys that users may want to touch before any other."""
    known = {field.key: field for fields in sections.values() for field in fields}
    rows = [('to say', 'key', 'default'), ('---',) * 3]
    rows += [(why, f'`{key}`', f'`{_scalar(known[key].default)}`') for key, why in _FIRST.items()]
    table = '\n'.join(f'| {" | ".join(row)} |' for row in rows)
    return (
        f'## The five to touch\n\nAll others have values that should do as they are.\n\n{table}\n'
    )


def _section_summary(name: str) -> str:
    section: Any = FpnetConfig()
    for part in name.split('.') if name else ():
        section = getattr(section, part)
    if not name:
        return 'What concerns all parts.'
    summary = (type(section).__doc__ or '').strip().splitlines()[0]
    return summary.replace(':mod:', '')


def _table_row(field: ConfigField) -> tuple[str, ...]:
    kind = f'list of {field.kind.__name__}' if field.is_list else field.kind.__name__
    return (
        f'`{field.key}`',
        kind,
        field.unit,
        field.constraint,
        f'`{_scalar(field.default)}`',
        field.description.replace(':mod:', '').replace('|', '\\|'),
    )


def _leaf(key: str, info: FieldInfo) -> ConfigField:
    kind, choices, is_list = _value_type(key, info.annotation)
    bounds = {
        name: float(getattr(item, name))
        for item in info.metadata
        for name in _BOUNDS
        if hasattr(item, name)
    }
    default = info.get_default(call_default_factory=True)
    return ConfigField(key, kind, default, info.description or '', bounds, choices, is_list)


def _value_type(key: str, annotation: Any) -> tuple[type, tuple[str, ...], bool]:
    """Return element type, choices and whether it is a list, for what a ROS parameter can hold."""
    if annotation in (bool, int, float, str):
        return annotation, (), False
    arguments = get_args(annotation)
    if get_origin(annotation) is Literal and all(isinstance(a, str) for a in arguments):
        return str, arguments, False
    if get_origin(annotation) in (list, tuple):
        kinds = {argument for argument in arguments if argument is not Ellipsis}
        if len(kinds) == 1 and kinds <= {bool, int, float, str}:
            return kinds.pop(), (), True
    if get_origin(annotation) in (Union, types.UnionType):
        raise TypeError(f'{key}: a ROS parameter has one type; use a sentinel instead of a union')
    raise TypeError(f'{key}: {annotation} cannot be a ROS parameter')


def _render_section(section: type[Section], values: Section, indent: str) -> Iterator[str]:
    for name, info in section.model_fields.items():
        value = getattr(values, name)
        if isinstance(value, Section):
            yield from _comment((type(value).__doc__ or '').strip().splitlines()[0], indent)
            yield f'{indent}{name}:'
            yield from _render_section(type(value), value, indent + '  ')
            continue
        field = _leaf(name, info)
        text = field.description + (f' ({field.constraint})' if field.constraint else '')
        yield from _comment(text, indent)
        yield f'{indent}{name}: {_scalar(value)}'


def _comment(text: str, indent: str) -> list[str]:
    return wrap(
        text.replace(':mod:', '').replace('`', ''),
        _COMMENT_WIDTH,
        initial_indent=f'{indent}# ',
        subsequent_indent=f'{indent}# ',
    )


def _scalar(value: Any) -> str:
    """Return the YAML of a value in one line, floats such that YAML reads floats."""
    plain = list(value) if isinstance(value, tuple) else value
    text = yaml.safe_dump(plain, default_flow_style=True, width=10**6)
    return text.removesuffix('\n').removesuffix('\n...')


if __name__ == '__main__':
    sys.stdout.write(render_markdown() if sys.argv[1:] == ['markdown'] else render_yaml())
