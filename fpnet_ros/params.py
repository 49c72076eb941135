# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""ROS parameters declared from pydantic sections, with type, range and description."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from difflib import get_close_matches
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
from fpnet_ros.settings import known_parameters

AnySection = TypeVar('AnySection', bound=Section)

_TYPES = {
    bool: (ParameterType.PARAMETER_BOOL, ParameterType.PARAMETER_BOOL_ARRAY),
    int: (ParameterType.PARAMETER_INTEGER, ParameterType.PARAMETER_INTEGER_ARRAY),
    float: (ParameterType.PARAMETER_DOUBLE, ParameterType.PARAMETER_DOUBLE_ARRAY),
    str: (ParameterType.PARAMETER_STRING, ParameterType.PARAMETER_STRING_ARRAY),
}
_INT64_MAX = 2**63 - 1  # given
_FRAMES = ('_frame', 'frame_id')  # given: suffixes of keys that name a frame
# Parameters of rclpy, read at the start or when a topic is created.
_OF_RCLPY = ('use_sim_time', 'start_type_description_service', 'qos_overrides')


class OwnValues(Node):
    """
    Node that accepts unchanged values at any time, so that it can load a dump of its parameters.

    ``ros2 param dump`` also writes parameters that cannot change, and it loses types: an empty
    list becomes a list of booleans, ``1e-05`` a string. Publishers and subscriptions of the
    ``add_...`` methods have parameters for their QoS.
    """

    way_to_change = 'is read when the node starts: restart it with another value'
    """Instructions to change a parameter that the node reads only once."""

    def add_publisher(self, kind: type, topic: str, qos: Any) -> Any:
        """Return a publisher with QoS overrides."""
        options = QoSOverridingOptions.with_default_policies()
        return self.create_publisher(kind, topic, qos, qos_overriding_options=options)

    def add_subscription(
        self, kind: type, topic: str, callback: Callable[..., None], qos: Any, raw: bool = False
    ) -> Any:
        """Subscribe; the callback takes the message (``raw``: its bytes), or also its details."""
        options = QoSOverridingOptions.with_default_policies()
        return self.create_subscription(
            kind, topic, callback, qos, qos_overriding_options=options, raw=raw
        )

    def set_parameters_atomically(self, parameter_list: list[Parameter[Any]]) -> Any:
        """Set the values that differ; refuse an unknown name and suggest a similar one."""
        for each in parameter_list:
            if not self.has_parameter(each.name):
                reason = said_of_unknown(each.name, self.list_parameters([], 0).names)
                return SetParametersResult(successful=False, reason=reason)
        changed = [
            each
            for each in parameter_list
            if _dumped(self.get_parameter_or(each.name).value) != _dumped(each.value)
        ]
        if not changed:
            return SetParametersResult(successful=True)
        return super().set_parameters_atomically(changed)


def _dumped(value: Any) -> str:
    """Return a value as a dump has it; unset and an empty list are the same there."""
    plain = list(value) if isinstance(value, Sequence) and not isinstance(value, str) else value
    return '' if plain in ([], None, 'None') else str(plain)


def refuse_unknown(node: Node) -> None:
    """Raise ConfigError if a given parameter is one of no node of this package."""
    given = node._parameter_overrides  # rclpy has no public access to them
    is_own = lambda name: node.has_parameter(name) or name.split('.')[0] in _OF_RCLPY  # noqa: E731
    raise_unknown((name for name in sorted(given) if not is_own(name)), known_parameters())


def raise_unknown(names: Iterable[str], known: set[str]) -> None:
    """Raise ConfigError for the first of ``names`` that is not among ``known``."""
    for name in names:
        if name not in known:
            raise ConfigError(said_of_unknown(name, known))


def said_of_unknown(name: str, known: Iterable[str]) -> str:
    """Return the message for an unknown parameter, with the most similar of ``known``."""
    near = get_close_matches(name, sorted(known), n=1)
    advice = f'did you mean {near[0]}?' if near else 'docs/ros.md lists all parameters'
    return f'parameter {name} is unknown; {advice}'


class ParameterTree(Generic[AnySection]):
    """
    Parameters for all keys below a section; ``value`` is the section with their current values.

    Names have a dotted ``prefix``, for example ``odometry.``. The subsections ``without`` keep
    their defaults, as the node does not read them. The keys ``live`` may change at any time;
    changes of others are refused while ``is_frozen``, which the node sets once it has read them.
    ``on_change`` is called after a change.

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
        self._section, self._prefix, self._live = section, prefix, frozenset(live)
        self._node, self._on_change = node, on_change
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
            reason = f'{fixed[0]} {self._node.way_to_change}'
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
            said = f'parameter {key}: {first["msg"]} (got {first["input"]!r})'
            raise ConfigError(said) from None


def _declare(node: Node, field: ConfigField) -> Any:
    descriptor = describe(field)
    default = list(field.default) if field.is_list else field.default
    # rclpy takes an empty list for bytes, so such a parameter is declared by its type alone.
    value = Parameter.Type(descriptor.type) if default == [] else default
    try:
        parameter = node.declare_parameter(field.key, value, descriptor)
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        wanted = f'{field.kind.__name__} {field.constraint}'.strip()
        raise ConfigError(f'parameter {field.key}: {error}; expected {wanted}') from None
    if parameter.type_ is Parameter.Type.NOT_SET:  # an unset parameter makes a dump fail
        node.set_parameters([Parameter(field.key, Parameter.Type(descriptor.type), [])])
        return field.default
    return parameter.value


def describe(field: ConfigField) -> ParameterDescriptor:
    """Return the descriptor of a key."""
    descriptor = ParameterDescriptor(
        name=field.key,
        type=_TYPES[field.kind][field.is_list],
        description=field.description,
        additional_constraints=field.constraint,
    )
    if field.bounds and field.kind in (int, float):
        low, high = _closed(field.kind, field.bounds)
        if field.kind is int:
            descriptor.integer_range = [IntegerRange(from_value=low, to_value=high, step=1)]
        else:
            bounds = FloatingPointRange(from_value=low, to_value=high, step=0.0)
            descriptor.floating_point_range = [bounds]
    return descriptor


def _closed(kind: type, bounds: dict[str, float]) -> tuple[Any, Any]:
    """Return a closed range; an open end moves to the next number inside."""
    most = _INT64_MAX if kind is int else sys.float_info.max
    low, high = bounds.get('ge', -most), bounds.get('le', most)
    if (above := bounds.get('gt')) is not None:
        low = math.floor(above) + 1 if kind is int else math.nextafter(above, math.inf)
    if (below := bounds.get('lt')) is not None:
        high = math.ceil(below) - 1 if kind is int else math.nextafter(below, -math.inf)
    return kind(low), kind(high)
