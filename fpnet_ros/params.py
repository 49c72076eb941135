# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ROS parameters declared from the configuration tree, with type, range and description."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
import math
import sys
from typing import Any, Generic, TypeVar

from pydantic import ValidationError
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterType,
    SetParametersResult,
)
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos_overriding_options import QoSOverridingOptions

from fpnet_core.config import Section
from fpnet_core.config_docs import ConfigField, config_fields
from fpnet_core.errors import ConfigError
from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_ros.known_parameters import said_of_unknown

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
_INT64_MAX = 2**63 - 1  # given
_FRAMES = ('_frame', 'frame_id')  # given: suffixes of keys that name a frame


class OwnValues(Node):
    """
    Node that accepts unchanged values at any time, so that it can load a dump of its parameters.

    ``ros2 param dump`` also writes parameters that cannot change, and it loses types: an empty
    list becomes a list of booleans, ``1e-05`` a string. Publishers and subscriptions of the
    ``add_...`` methods have parameters for their QoS.
    """

    def add_publisher(self, kind: type, topic: str, qos: Any) -> Any:
        """Return a publisher with QoS overrides."""
        options = QoSOverridingOptions.with_default_policies()
        return self.create_publisher(kind, topic, qos, qos_overriding_options=options)

    def add_subscription(
        self, kind: type, topic: str, callback: Callable[..., None], qos: Any, raw: bool = False
    ) -> Any:
        """
        Subscribe; the callback takes the message, or the message and its information.

        With ``raw`` the message is passed as serialized bytes.
        """
        options = QoSOverridingOptions.with_default_policies()
        return self.create_subscription(
            kind, topic, callback, qos, qos_overriding_options=options, raw=raw
        )

    def set_parameters_atomically(self, parameter_list: list[Parameter[Any]]) -> Any:
        """Set the values that differ; refuse an unknown name and suggest a similar one."""
        unknown = [each.name for each in parameter_list if not self.has_parameter(each.name)]
        if unknown:
            own = self.list_parameters([], 0).names
            return SetParametersResult(successful=False, reason=said_of_unknown(unknown[0], own))
        changed = [each for each in parameter_list if not self._has(each)]
        if not changed:
            return SetParametersResult(successful=True)
        return super().set_parameters_atomically(changed)

    @property
    def way_to_change(self) -> str:
        """Instructions to change a parameter that the node reads only once."""
        return 'is read when the node starts: restart it with another value'

    def _has(self, given: Parameter[Any]) -> bool:
        own = self.get_parameter_or(given.name).value
        return _dumped(own) == _dumped(given.value)


def _dumped(value: Any) -> str:
    """Return a value as a dump has it; unset and an empty list are the same there."""
    plain = list(value) if isinstance(value, Sequence) and not isinstance(value, str) else value
    return '' if plain in ([], None, 'None') else str(plain)


class ParameterTree(Generic[AnySection]):
    """
    Parameters for all keys below a section of the configuration tree.

    ``value`` is the section with the current values of the node's parameters.

    Parameters
    ----------
    section
        The keys, with type, range, description and default.
    prefix
        Dotted prefix of every name, for example ``odometry.``.
    without
        Names of subsections that this node does not read; they keep their defaults.
    live
        Keys that may change at any time. Changes of others are refused while ``is_frozen``,
        which the node sets once it has read them.
    on_change
        Called after a change.

    Raises
    ------
    ConfigError
        If a parameter's value has the wrong type or is out of range.
    """

    def __init__(
        self,
        node: OwnValues,
        section: type[AnySection],
        prefix: str = '',
        without: Collection[str] = (),
        live: Collection[str] = (),
        on_change: Callable[[], None] = lambda: None,
    ) -> None:
        self._section = section
        self._prefix = prefix
        self._live = frozenset(live)
        self._on_change = on_change
        self._way_to_change = lambda: node.way_to_change
        self.is_frozen = True
        self._values = {
            field.key: _declare(node, field)
            for field in config_fields(section, prefix)
            if field.key.removeprefix(prefix).split('.')[0] not in without
        }
        self.value = self._validated(self._values)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._take)

    def _check(self, parameters: list[Parameter[Any]]) -> SetParametersResult:
        changes = self._own(parameters)
        if self.is_frozen and (fixed := sorted(set(changes) - self._live)):
            reason = f'{fixed[0]} {self._way_to_change()}'
            return SetParametersResult(successful=False, reason=reason)
        try:
            self._validated({**self._values, **changes})
        except ConfigError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _take(self, parameters: list[Parameter[Any]]) -> None:
        if changes := self._own(parameters):
            self._values |= changes
            self.value = self._validated(self._values)
            self._on_change()

    def _own(self, parameters: list[Parameter[Any]]) -> dict[str, Any]:
        return {p.name: p.value for p in parameters if p.name in self._values}

    def _validated(self, values: dict[str, Any]) -> AnySection:
        tree: dict[str, Any] = {}
        for key, value in values.items():
            *parents, leaf = key.removeprefix(self._prefix).split('.')
            branch = tree
            for part in parents:
                branch = branch.setdefault(part, {})
            branch[leaf] = plain_frame(value) if leaf.endswith(_FRAMES) else value
        try:
            return self._section.model_validate(tree)
        except ValidationError as error:
            first = error.errors()[0]
            key = self._prefix + '.'.join(str(part) for part in first['loc'])
            raise ConfigError(
                f'parameter {key}: {first["msg"]} (got {first["input"]!r})'
            ) from None


def _declare(node: Node, field: ConfigField) -> Any:
    descriptor = describe(field)
    default = list(field.default) if field.is_list else field.default
    # rclpy takes an empty list for bytes, so such a parameter is declared by its type alone.
    value = Parameter.Type(descriptor.type) if default == [] else default
    try:
        parameter = node.declare_parameter(field.key, value, descriptor)
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        raise ConfigError(
            f'parameter {field.key}: {error}; expected {field.kind.__name__}'
            + (f' {field.constraint}' if field.constraint else '')
        ) from None
    if parameter.type_ is Parameter.Type.NOT_SET:  # an unset parameter makes a dump fail
        node.set_parameters([Parameter(field.key, Parameter.Type(descriptor.type), [])])
        return field.default
    return parameter.value


def describe(field: ConfigField) -> ParameterDescriptor:
    """Return the descriptor of a key."""
    descriptor = ParameterDescriptor(
        name=field.key,
        type=(_LIST_TYPES if field.is_list else _TYPES)[field.kind],
        description=field.description,
        additional_constraints=field.constraint,
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
