# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ROS parameters declared from the configuration tree, with type, range and description."""

from __future__ import annotations

from collections.abc import Collection
import math
import sys
from typing import Any, TypeVar

from pydantic import ValidationError
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterType,
)
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from fpnet_core.config import Section
from fpnet_core.config_docs import ConfigField, config_fields
from fpnet_core.errors import ConfigError

AnySection = TypeVar('AnySection', bound=Section)

_TYPES = {
    bool: ParameterType.PARAMETER_BOOL,
    int: ParameterType.PARAMETER_INTEGER,
    float: ParameterType.PARAMETER_DOUBLE,
    str: ParameterType.PARAMETER_STRING,
}
_LIST_TYPES = {
    bool: ParameterType.PARAMETER_BOOL_ARRAY,
    int: ParameterType.PARAMETER_INTEGER_ARRAY,
    float: ParameterType.PARAMETER_DOUBLE_ARRAY,
    str: ParameterType.PARAMETER_STRING_ARRAY,
}
_INT64_MAX = 2**63 - 1


def declare_section(
    node: Node, section: type[AnySection], prefix: str = '', without: Collection[str] = ()
) -> AnySection:
    """
    Declare a parameter for every key below ``section`` and return the values given to the node.

    Parameters
    ----------
    prefix
        Dotted start of every name, as ``odometry.``.
    without
        Names of subsections that this node does not read: they keep their defaults.

    Raises
    ------
    ConfigError
        If a parameter's value has the wrong type or is out of range.
    """
    tree: dict[str, Any] = {}
    for field in config_fields(section, prefix):
        *parents, leaf = field.key.removeprefix(prefix).split('.')
        if parents and parents[0] in without:
            continue
        branch = tree
        for part in parents:
            branch = branch.setdefault(part, {})
        branch[leaf] = _declare(node, field)
    try:
        return section.model_validate(tree)
    except ValidationError as error:
        first = error.errors()[0]
        key = prefix + '.'.join(str(part) for part in first['loc'])
        raise ConfigError(f'parameter {key}: {first["msg"]} (got {first["input"]!r})') from None


def _declare(node: Node, field: ConfigField) -> Any:
    descriptor = describe(field)
    default = list(field.default) if field.is_list else field.default
    # rclpy takes an empty list for one of bytes, so that parameter is declared by type alone.
    value = Parameter.Type(descriptor.type) if default == [] else default
    try:
        parameter = node.declare_parameter(field.key, value, descriptor)
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        raise ConfigError(
            f'parameter {field.key}: {error}; expected {field.kind.__name__}'
            + (f' {field.constraint}' if field.constraint else '')
        ) from None
    if parameter.type_ is Parameter.Type.NOT_SET:
        return field.default
    return parameter.value


def describe(field: ConfigField) -> ParameterDescriptor:
    """Return the descriptor of a key; read-only, as the core takes its configuration once."""
    descriptor = ParameterDescriptor(
        name=field.key,
        type=(_LIST_TYPES if field.is_list else _TYPES)[field.kind],
        description=field.description,
        additional_constraints=field.constraint,
        read_only=True,
    )
    if field.bounds and field.kind is int:
        descriptor.integer_range = [_integer_range(field.bounds)]
    elif field.bounds and field.kind is float:
        descriptor.floating_point_range = [_floating_range(field.bounds)]
    return descriptor


def _floating_range(bounds: dict[str, float]) -> FloatingPointRange:
    """Return the closed range; an open end moves to the next number inside."""
    low, high = -sys.float_info.max, sys.float_info.max
    low = bounds.get('ge', low)
    high = bounds.get('le', high)
    if 'gt' in bounds:
        low = math.nextafter(bounds['gt'], math.inf)
    if 'lt' in bounds:
        high = math.nextafter(bounds['lt'], -math.inf)
    return FloatingPointRange(from_value=low, to_value=high, step=0.0)


def _integer_range(bounds: dict[str, float]) -> IntegerRange:
    low, high = -_INT64_MAX, _INT64_MAX
    low = int(bounds.get('ge', low))
    high = int(bounds.get('le', high))
    if 'gt' in bounds:
        low = math.floor(bounds['gt']) + 1
    if 'lt' in bounds:
        high = math.ceil(bounds['lt']) - 1
    return IntegerRange(from_value=low, to_value=high, step=1)
