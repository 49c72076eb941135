# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``ros2 param dump`` and ``load`` of a node's own values."""

from pathlib import Path

from pydantic import Field
import pytest
import rclpy
from rclpy.parameter import Parameter, parameter_dict_from_yaml_file
from rclpy.qos_overriding_options import QoSOverridingOptions
from std_msgs.msg import String
import yaml

from fpnet_core.config import FpnetConfig, Section
from fpnet_lab.nodes.processes import free_domain_id
from fpnet_lab.nodes.replay import ReplayNode
from fpnet_ros.params import OwnValues, ParameterTree
from fpnet_ros.settings import LIVE, SECTIONS, LocalizerParameters, render_parameter_file

pytestmark = pytest.mark.ros


SHIPPED = Path(__file__).parents[2] / 'config' / 'fpnet.yaml'


def test_the_shipped_file_has_every_parameter_of_every_node():
    text = SHIPPED.read_text(encoding='utf-8')
    assert text == render_parameter_file(), 'see docs/contributing.md'
    begin = text.index('## localizer')
    written = ''.join(line.removeprefix('    # ') for line in text[begin:].splitlines(True))
    for part, section in zip(written.split('## ')[1:], SECTIONS.values(), strict=True):
        values = yaml.safe_load(part.partition('\n')[2])
        assert section.model_validate(values) == section()
        assert set(values) == set(section.model_fields)


class Framed(Section):
    scan_frame: str = Field('/laser', description='A frame.')


@pytest.fixture
def node(monkeypatch):
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    given = ['--ros-args', '-p', 'path_spacing_m:=1e-05', '-p', 'base_frame:=base_link']
    given += ['-p', 'bag:=drive']
    rclpy.init(args=given, domain_id=free_domain_id())
    node = OwnValues('finder')
    ParameterTree(node, LocalizerParameters, live=LIVE)
    ParameterTree(node, FpnetConfig)
    overriding = QoSOverridingOptions.with_default_policies()
    node.create_subscription(String, 'words', print, 1, qos_overriding_options=overriding)
    yield node
    node.destroy_node()
    rclpy.shutdown()


def dumped(node) -> dict:
    """Return a node's parameters as ``ros2 param dump`` writes them."""
    names = node.list_parameters([], 0).names
    found = {}
    for name in names:
        value = node.get_parameter_or(name).value
        found[name] = list(value) if hasattr(value, 'typecode') else value
    return found


def loaded(node, values: dict, path) -> dict[str, str]:
    """Load a dump as ``ros2 param load`` does; return why, by name, of what was refused."""
    path.write_text(yaml.dump({'/finder': {'ros__parameters': values}}))
    refused = {}
    for message in parameter_dict_from_yaml_file(str(path)).values():
        result = node.set_parameters_atomically([Parameter.from_parameter_msg(message)])
        if not result.successful:
            refused[message.name] = result.reason
    return refused


def test_frames_have_no_slash_before_them(node):
    """tf2 asks without one."""
    assert ParameterTree(node, Framed).value.scan_frame == 'laser'


def test_a_nodes_own_dump_is_accepted_and_changes_nothing(node, tmp_path):
    values = dumped(node)
    assert values['path_spacing_m'] == 1e-05
    assert any(name.startswith('qos_overrides') for name in values), 'read-only ones'
    assert values['scan_topics'] == []
    assert loaded(node, values, tmp_path / 'dump.yaml') == {}
    assert dumped(node) == values


def test_the_player_accepts_its_own_dump(node, tmp_path):
    replay = ReplayNode()
    values = dumped(replay)
    assert (values['bag'], values['topics']) == ('drive', [])
    assert loaded(replay, values, tmp_path / 'dump.yaml') == {}
    assert loaded(replay, values | {'rate': 2.0}, tmp_path / 'dump.yaml').keys() == {'rate'}
    replay.destroy_node()


def test_what_a_dump_was_edited_to_say_is_set_or_refused_with_its_reason(node, tmp_path):
    values = dumped(node) | {'transform_tolerance': 0.25, 'base_frame': 'base', 'tf_rate_hz': 5.0}
    values['max_pending_scans'] = 7
    refused = loaded(node, values, tmp_path / 'dump.yaml')
    assert set(refused) == {'base_frame', 'max_pending_scans'}
    assert 'is read when the node starts: restart it' in refused['base_frame']
    assert node.get_parameter('transform_tolerance').value == 0.25
    assert node.get_parameter('tf_rate_hz').value == 5.0


def test_a_name_that_does_not_exist_is_refused_with_the_one_meant(node):
    result = node.set_parameters_atomically([Parameter('transform_tolernce', value=0.1)])
    assert not result.successful
    assert result.reason.endswith('is unknown; did you mean transform_tolerance?')
