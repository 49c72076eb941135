# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What launch files and package.xml name exists.

No wheel has ``launch``; stand-ins note what they are given, with the names and keywords of
Jazzy's. Parameters are checked against those that the nodes declare.
"""

import ast
from collections.abc import ItemsView
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
import re
import sys
from types import ModuleType
import xml.etree.ElementTree as ET

import pytest

pytest.importorskip('rclpy')

from fpnet_core.config import FpnetConfig, OdometryConfig
from fpnet_core.config_docs import config_fields
from fpnet_ros.floorplan_server import FloorplanServerParameters
from fpnet_ros.lifecycle import LifecycleParameters
from fpnet_ros.odometry import OdometryParameters
from fpnet_ros.replay import ReplayParameters
from fpnet_ros.settings import LocalizerParameters

pytestmark = pytest.mark.ros

ROOT = Path(__file__).parents[2]
SECTIONS = {
    'localizer': (LocalizerParameters, LifecycleParameters, FpnetConfig),
    'floorplan_server': (FloorplanServerParameters, LifecycleParameters),
    'odometry': (OdometryParameters,),
    'replay': (ReplayParameters,),
}
CLASSES = {
    'launch': ('LaunchDescription',),
    'launch.actions': ('DeclareLaunchArgument', 'GroupAction', 'IncludeLaunchDescription'),
    'launch.conditions': ('IfCondition',),
    'launch.launch_description_sources': ('PythonLaunchDescriptionSource',),
    'launch.substitutions': ('LaunchConfiguration', 'PathJoinSubstitution'),
    'launch_ros': (),
    'launch_ros.actions': ('Node', 'PushRosNamespace'),
    'launch_ros.parameter_descriptions': ('ParameterValue',),
    'launch_ros.substitutions': ('FindPackageShare',),
}


class Noted:
    """Keeps what it was made with."""

    def __init__(self, *arguments, **keywords) -> None:
        self.arguments, self.keywords = arguments, keywords


def _parameters(executable: str) -> set[str]:
    keys = {field.key for section in SECTIONS[executable] for field in config_fields(section)}
    if executable == 'odometry':
        keys |= {field.key for field in config_fields(OdometryConfig, 'odometry.')}
    return keys | {'use_sim_time'}


@pytest.fixture
def described(monkeypatch):
    """Load a launch file; returns everything in its description, by the class's name."""
    for module_name, class_names in CLASSES.items():
        module = ModuleType(module_name)
        for name in class_names:
            setattr(module, name, type(name, (Noted,), {}))
        monkeypatch.setitem(sys.modules, module_name, module)

    def flat(item):
        yield item
        if isinstance(item, (list, tuple, ItemsView)):
            children = item
        elif isinstance(item, dict):
            children = item.items()
        elif isinstance(item, Noted):
            children = [*item.arguments, *item.keywords.values()]
        else:
            return
        for child in children:
            yield from flat(child)

    def load(name: str) -> dict[str, list[Noted]]:
        spec = spec_from_file_location(name, ROOT / 'launch' / f'{name}.launch.py')
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        found = {}
        for item in flat(module.generate_launch_description()):
            if isinstance(item, Noted):
                found.setdefault(type(item).__name__, []).append(item)
        return found

    return load


def _declared(found) -> set[str]:
    return {action.arguments[0] for action in found['DeclareLaunchArgument']}


@pytest.mark.parametrize('name', ['localizer', 'demo'])
def test_nodes_exist_and_declare_what_they_are_given(described, name):
    found = described(name)
    ours = [n.keywords for n in found['Node'] if n.keywords['package'] == 'fpnet_ros']
    assert ours
    for node in ours:
        executable = node['executable']
        given = [p for p in node['parameters'] if isinstance(p, dict)]
        assert {key for p in given for key in p} <= _parameters(executable), executable
    used = {item.arguments[0] for item in found['LaunchConfiguration']}
    assert used == _declared(found)


def test_the_demo_sets_arguments_that_the_localizer_s_launch_file_has(described):
    (include,) = described('demo')['IncludeLaunchDescription']
    assert set(dict(include.keywords['launch_arguments'])) <= _declared(described('localizer'))


def test_every_launch_argument_is_documented(described):
    page = (ROOT / 'docs' / 'ros.md').read_text()
    for name in ('localizer', 'demo'):
        for argument in _declared(described(name)):
            assert f'`{argument}`' in page, argument


def test_every_parameter_of_the_nodes_is_documented():
    page = (ROOT / 'docs' / 'ros.md').read_text()
    names = set(re.findall(r'`([\w.]+)`', page))
    for sections in SECTIONS.values():
        for section in sections:
            if section is not FpnetConfig:
                missing = {field.key for field in config_fields(section)} - names
                assert not missing, section


def test_every_message_package_is_a_dependency():
    root = ET.parse(ROOT / 'package.xml').getroot()
    known = {element.text for element in root.findall('exec_depend')}
    imported = set()
    for folder in ('fpnet_ros', 'msg_adapters', 'launch'):
        for path in (ROOT / folder).glob('*.py'):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.ImportFrom) and node.module:
                    imported.add(node.module.partition('.')[0])
    ros = {name for name in imported if name.endswith(('_msgs', '_srvs', '_interfaces'))}
    assert len(ros) > 8
    assert ros | {'rclpy', 'launch', 'launch_ros'} <= known
