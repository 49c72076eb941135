# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What launch files and package.xml name exists.

No wheel has ``launch``; stand-ins note what they are given, with the names and keywords of
Jazzy's, and look arguments up as it does. Parameters are checked against those that the nodes
declare.
"""

import ast
from collections.abc import ItemsView
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
import re
import sys
from types import ModuleType, SimpleNamespace
import xml.etree.ElementTree as ET

from ament_index_python.packages import PackageNotFoundError
import pytest

pytest.importorskip('rclpy')

from fpnet_core.config import FpnetConfig, OdometryConfig, ScansConfig
from fpnet_core.config_docs import config_fields
from fpnet_ros.settings import (
    FloorplanServerParameters,
    LifecycleParameters,
    LocalizerParameters,
    OdometryParameters,
    ReplayParameters,
    SeederParameters,
)
from fpnet_ros.wiring import PROFILE_VARIABLE, said_of_transport

pytestmark = pytest.mark.ros

ROOT = Path(__file__).parents[2]
SECTIONS = {
    'localizer': (LocalizerParameters, LifecycleParameters, FpnetConfig),
    'floorplan_server': (FloorplanServerParameters, LifecycleParameters),
    'odometry': (OdometryParameters,),
    'replay': (ReplayParameters,),
    'seeder': (SeederParameters,),
}
CLASSES = {
    'launch': ('LaunchDescription',),
    'launch.actions': (
        'DeclareLaunchArgument',
        'GroupAction',
        'IncludeLaunchDescription',
        'LogInfo',
        'OpaqueFunction',
        'SetEnvironmentVariable',
        'Shutdown',
    ),
    'launch.conditions': ('IfCondition',),
    'launch.launch_description_sources': ('PythonLaunchDescriptionSource',),
    'launch.substitutions': (
        'EnvironmentVariable',
        'LaunchConfiguration',
        'PathJoinSubstitution',
    ),
    'launch_ros': (),
    'launch_ros.actions': ('Node', 'PushRosNamespace'),
    'launch_ros.parameter_descriptions': ('ParameterValue',),
    'launch_ros.substitutions': ('FindPackageShare',),
}


class Noted:
    """Keeps what it was made with."""

    def __init__(self, *arguments, **keywords) -> None:
        self.arguments, self.keywords = arguments, keywords

    def perform(self, context):
        """Return an argument's value, as of a LaunchConfiguration."""
        context['used'].add(self.arguments[0])
        return context[self.arguments[0]]

    def evaluate(self, context):
        """Tell whether an IfCondition holds."""
        return self.arguments[0].perform(context) == 'true'


def _parameters(executable: str) -> set[str]:
    keys = {field.key for section in SECTIONS[executable] for field in config_fields(section)}
    if executable == 'odometry':
        keys |= {field.key for field in config_fields(OdometryConfig, 'odometry.')}
        keys |= {field.key for field in config_fields(ScansConfig, 'scans.')}
    return keys | {'use_sim_time'}


@pytest.fixture
def described(monkeypatch):
    """Load a launch file; returns everything in its description, by the class's name."""
    for module_name, class_names in CLASSES.items():
        module = ModuleType(module_name)
        for name in class_names:
            setattr(module, name, type(name, (Noted,), {}))
        monkeypatch.setitem(sys.modules, module_name, module)
    monkeypatch.setenv('AMENT_PREFIX_PATH', sys.prefix)  # as ros2 launch has it

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

    def load(name: str, **given: str) -> dict[str, list[Noted]]:
        spec = spec_from_file_location(name, ROOT / 'launch' / f'{name}.launch.py')
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        found = {}

        def note(description) -> None:
            for item in flat(description):
                if isinstance(item, Noted):
                    found.setdefault(type(item).__name__, []).append(item)

        note(module.generate_launch_description())
        declared = {d.arguments[0]: d.keywords for d in found['DeclareLaunchArgument']}
        assert set(given) <= set(declared)
        context = {name: words['default_value'] for name, words in declared.items()}
        context |= given | {'used': set()}
        for action in found.get('OpaqueFunction', []):
            note(action.keywords['function'](context))
        found['used'] = context['used'] | {c.arguments[0] for c in found['LaunchConfiguration']}
        return found

    return load


def _declared(found) -> set[str]:
    return {action.arguments[0] for action in found['DeclareLaunchArgument']}


def _parameters_of(found, executable: str) -> dict[str, object]:
    """Return what a node is given beside the parameter file."""
    (node,) = [n.keywords for n in found['Node'] if n.keywords['executable'] == executable]
    given = {}
    for parameters in node['parameters']:
        given |= parameters if isinstance(parameters, dict) else {}
    return {
        name: value.arguments[0] if isinstance(value, Noted) else value
        for name, value in given.items()
    }


EVERYTHING = {
    'localizer': {
        'floorplan': 'a.png', 'resolution_m': '0.05', 'storey': '1', 'page': '2', 'scan': '/scan',
        'floorplan_frame': 'map', 'base_frame': 'base_link', 'use_sim_time': 'true',
        'autostart': 'false', 'state_file': 'state.npz', 'odometry': 'both', 'scan_stamp': 'end',
        'odom_frame': 'odom', 'publish_odom_tf': 'false', 'namespace': 'robot_1',
        'hand_over': 'true', 'other_source': 'pose', 'other_pose': '/lio/pose',
    },
    'demo': {'bag': 'bag', 'floorplan': 'a.yaml', 'scan': '/scan'},
}  # fmt: skip


@pytest.mark.parametrize('name', ['localizer', 'demo'])
def test_nodes_exist_and_declare_what_they_are_given(described, name):
    found = described(name, **EVERYTHING[name])
    ours = [n.keywords for n in found['Node'] if n.keywords['package'] == 'fpnet_ros']
    assert ours
    for node in ours:
        executable = node['executable']
        given = [p for p in node['parameters'] if isinstance(p, dict)]
        assert {key for p in given for key in p} <= _parameters(executable), executable
    assert found['used'] == _declared(found)


def test_what_nobody_set_is_left_to_the_parameter_file(described):
    found = described('localizer', floorplan='plan.yaml')
    assert set(_parameters_of(found, 'floorplan_server')) == {'floorplan'}
    assert _parameters_of(found, 'odometry') == _parameters_of(found, 'localizer') == {}
    found = described('localizer', floorplan='plan.yaml', base_frame='base_link')
    assert set(_parameters_of(found, 'odometry')) == {'base_frame'}


def test_a_node_that_cannot_start_ends_the_launch_and_one_that_dies_is_told(described):
    found = described('localizer', floorplan='plan.yaml')
    nodes = [n.keywords for n in found['Node'] if n.keywords['package'] == 'fpnet_ros']
    assert len(nodes) == 3
    for node in nodes:
        ended = {
            status: node['on_exit'](SimpleNamespace(process_name='it', returncode=status), None)
            for status in (0, 1, -9)
        }
        assert ended[0] == []
        (shutdown,), (told,) = ended[1], ended[-9]
        assert (type(shutdown).__name__, type(told).__name__) == ('Shutdown', 'LogInfo')
        assert 'it cannot start' in shutdown.keywords['reason']
        assert 'it has died (-9)' in told.keywords['msg']


@pytest.mark.parametrize('is_installed', [True, False])
def test_where_rviz_is_not_installed_a_line_says_so_and_the_nodes_start(
    described, monkeypatch, is_installed
):
    def prefix(name: str) -> str:
        if not is_installed:
            raise PackageNotFoundError(name)
        return '/opt/ros/jazzy'

    monkeypatch.setattr('ament_index_python.packages.get_package_prefix', prefix)
    found = described('localizer', floorplan='plan.yaml', rviz='true')
    packages = [node.keywords['package'] for node in found['Node']]
    said = [each for each in found.get('LogInfo', []) if 'rviz2' in each.keywords['msg']]
    assert packages.count('fpnet_ros') == 3
    assert (packages.count('rviz2'), len(said)) == ((1, 0) if is_installed else (0, 1))
    assert all(
        each.keywords['condition'].evaluate({'used': set(), 'rviz': 'true'}) for each in said
    )


def test_nodes_take_a_log_level_and_may_be_started_again(described):
    found = described('localizer', floorplan='a.yaml')
    for node in (n.keywords for n in found['Node'] if n.keywords['package'] == 'fpnet_ros'):
        assert node['arguments'][:2] == ['--ros-args', '--log-level']
        assert node['arguments'][2].arguments == ('log_level',)
        assert node['respawn'].arguments == ('respawn',)


@pytest.mark.parametrize('has_room', [True, False])
def test_the_profile_for_large_clouds_is_set_where_nobody_set_one(
    described, monkeypatch, has_room
):
    monkeypatch.delenv(PROFILE_VARIABLE, raising=False)
    monkeypatch.setattr('fpnet_ros.wiring.has_shared_memory', lambda: has_room)
    found = described('localizer', floorplan='a.yaml')
    given = [each.arguments for each in found.get('SetEnvironmentVariable', [])]
    if not has_room:
        assert given == []
        assert any('shared memory' in each.keywords['msg'] for each in found['LogInfo'])
        return
    ((name, profile),) = given
    assert (name, profile.arguments) == (PROFILE_VARIABLE, (PROFILE_VARIABLE,))
    *_, folder, file = profile.keywords['default_value'].arguments[0]
    assert (ROOT / folder / file).is_file()
    assert 'SetEnvironmentVariable' not in described('localizer', floorplan='a', dds_profile='')


def test_nodes_say_what_large_clouds_need_where_no_profile_is_set():
    assert PROFILE_VARIABLE in said_of_transport('rmw_fastrtps_cpp', {})
    assert said_of_transport('rmw_fastrtps_cpp', {PROFILE_VARIABLE: '/a.xml'}) == ''
    assert said_of_transport('rmw_cyclonedds_cpp', {}) == ''


def test_scans_go_to_our_odometry_or_else_to_the_localizer(described):
    found = described('localizer', floorplan='a.yaml', scan='/front/scan, /rear/scan')
    topics = {'scan_topics': ['/front/scan', '/rear/scan']}
    assert _parameters_of(found, 'odometry') == topics
    assert _parameters_of(found, 'localizer') == {}
    found = described('localizer', floorplan='a', scan='/scan', odometry='robot', odom_topic='/o')
    assert _parameters_of(found, 'localizer') == {'scan_topics': ['/scan']}
    assert 'odometry' not in [n.keywords['executable'] for n in found['Node']]


def test_the_demo_plays_scans_or_else_clouds(described):
    played = _parameters_of(described('demo', bag='b', floorplan='a.yaml'), 'replay')
    assert played['topics'] == ['/points']
    played = _parameters_of(described('demo', bag='b', floorplan='a', scan='/scan'), 'replay')
    assert played['topics'] == ['/scan']


def test_the_demo_sets_arguments_that_the_localizer_s_launch_file_has(described):
    (include,) = described('demo')['IncludeLaunchDescription']
    assert set(dict(include.keywords['launch_arguments'])) <= _declared(
        described('localizer', floorplan='a')
    )


def test_every_launch_argument_is_documented(described):
    page = (ROOT / 'docs' / 'ros.md').read_text()
    for name in ('localizer', 'demo'):
        for argument in _declared(described(name, **EVERYTHING[name])):
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
    assert ros | {'ament_index_python', 'rclpy', 'launch', 'launch_ros'} <= known


def test_what_only_the_lab_imports_is_no_dependency_of_a_robot():
    known = {element.text for element in ET.parse(ROOT / 'package.xml').findall('exec_depend')}
    imported = set()
    for folder in ('fpnet', 'fpnet_core', 'fpnet_ros', 'msg_adapters'):
        for path in (ROOT / folder).rglob('*.py'):
            for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
                if isinstance(node, ast.Import):
                    imported |= {each.name.partition('.')[0] for each in node.names}
                if isinstance(node, ast.ImportFrom) and node.module:
                    imported.add(node.module.partition('.')[0])
    imported -= {'torch', 'open3d'}  # for the paper's network, and clouds of the command line
    names = {'PIL': 'pil', 'cv2': 'opencv', 'open3d': 'open3d-pip', 'rosbags': 'rosbags-pip'}
    modules = ('networkx', 'sklearn', 'PIL', 'cv2', 'scipy', 'skimage', 'rosbags')
    for module in (*modules, 'open3d', 'torch'):
        key = f'python3-{names.get(module, module)}'
        assert (key in known) == (module in imported), key
