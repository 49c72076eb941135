# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Check for unknown parameters, so that a misspelt one does not silently keep its default."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from importlib import import_module

from rclpy.node import Node

from fpnet_core.config import FpnetConfig, Section
from fpnet_core.config_docs import config_fields
from fpnet_core.errors import ConfigError

# Parameters of rclpy, read at the start or when a topic is created.
_OF_RCLPY = ('use_sim_time', 'start_type_description_service', 'qos_overrides')


_SECTIONS = {
    'localizer': ('settings', 'LocalizerParameters'),
    'odometry': ('odometry', 'OdometryParameters'),
    'floorplan_server': ('floorplan_server', 'FloorplanServerParameters'),
    'localizer and floorplan_server': ('lifecycle', 'LifecycleParameters'),
    'replay': ('replay', 'ReplayParameters'),
    'seeder': ('seeder', 'SeederParameters'),
}
"""Module and class of parameters by node."""


def refuse_unknown(node: Node) -> None:
    """
    Refuse given parameters that no node of this package reads.

    Keys of other nodes are accepted, because one file may configure all nodes.

    Raises
    ------
    ConfigError
        If a parameter is unknown; the message suggests the most similar name.
    """
    # rclpy has no public access to them.
    given = node._parameter_overrides
    own = {name for name in given if node.has_parameter(name)}
    own |= {name for name in given if name.split('.')[0] in _OF_RCLPY}
    known = {field.key for field in config_fields(FpnetConfig)}
    unknown = set(given) - own - known
    if unknown:  # importing the modules of other nodes takes seconds
        known |= of_all_nodes()
        raise_unknown(sorted(unknown - known), known)


def raise_unknown(names: Iterable[str], known: set[str]) -> None:
    """Raise ConfigError for the first of ``names``, with the most similar of ``known``."""
    for name in names:
        raise ConfigError(said_of_unknown(name, known))


def said_of_unknown(name: str, known: Iterable[str]) -> str:
    """Return the message for an unknown parameter, with the most similar of ``known``."""
    near = get_close_matches(name, sorted(known), n=1)
    advice = f'did you mean {near[0]}?' if near else 'docs/ros.md lists all parameters'
    return f'parameter {name} is unknown; {advice}'


def of_all_nodes() -> set[str]:
    """Return the names of all nodes' parameters outside the configuration tree."""
    return {field.key for section in node_sections().values() for field in config_fields(section)}


def node_sections() -> dict[str, type[Section]]:
    """Return the sections of parameters outside the configuration tree, by nodes."""
    # Imported by name, because every node's module imports this one.
    return {
        nodes: getattr(import_module(f'fpnet_ros.{module}'), name)
        for nodes, (module, name) in _SECTIONS.items()
    }
