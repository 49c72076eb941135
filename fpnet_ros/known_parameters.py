# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters that nobody reads: a misspelt one must not pass for the default."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from importlib import import_module

from rclpy.node import Node

from fpnet_core.config import FpnetConfig, Section
from fpnet_core.config_docs import config_fields
from fpnet_core.errors import ConfigError

# What rclpy itself reads, at the start or with a topic that comes later.
_OF_RCLPY = ('use_sim_time', 'start_type_description_service', 'qos_overrides')


_SECTIONS = {
    'localizer': ('settings', 'LocalizerParameters'),
    'odometry': ('odometry', 'OdometryParameters'),
    'floorplan_server': ('floorplan_server', 'FloorplanServerParameters'),
    'localizer and floorplan_server': ('lifecycle', 'LifecycleParameters'),
    'replay': ('replay', 'ReplayParameters'),
}
"""Module and class of their parameters by nodes."""


def refuse_unknown(node: Node) -> None:
    """
    Check that somebody reads every parameter that a node was given.

    A file for all nodes holds keys that only another one of this package reads; those are fine.

    Raises
    ------
    ConfigError
        If there is one that no node of this package knows; it names what may have been meant.
    """
    # rclpy has no public way to them.
    given = node._parameter_overrides
    own = {name for name in given if node.has_parameter(name)}
    own |= {name for name in given if name.split('.')[0] in _OF_RCLPY}
    known = {field.key for field in config_fields(FpnetConfig)}
    unknown = set(given) - own - known
    if unknown:  # the other nodes' modules take seconds to load
        known |= of_all_nodes()
        raise_unknown(sorted(unknown - known), known)


def raise_unknown(names: Iterable[str], known: set[str]) -> None:
    """Raise ConfigError about the first of ``names``, with the ``known`` one that is nearest."""
    for name in names:
        raise ConfigError(said_of_unknown(name, known))


def said_of_unknown(name: str, known: Iterable[str]) -> str:
    """Return that a parameter does not exist, and which of the ``known`` ones was meant."""
    near = get_close_matches(name, sorted(known), n=1)
    advice = f'did you mean {near[0]}?' if near else 'docs/ros.md lists those that exist'
    return f'parameter {name} is unknown; {advice}'


def of_all_nodes() -> set[str]:
    """Return the names of the parameters that nodes of this package have of their own."""
    return {field.key for section in node_sections().values() for field in config_fields(section)}


def node_sections() -> dict[str, type[Section]]:
    """Return what nodes take beside the configuration tree, by the nodes that take it."""
    # By name, as every node's module needs this one to start.
    return {
        nodes: getattr(import_module(f'fpnet_ros.{module}'), name)
        for nodes, (module, name) in _SECTIONS.items()
    }
