# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What each robot's arguments make of the nodes: never two parents of its base."""

from itertools import product

import pytest

from fpnet_core.errors import ConfigError
from fpnet_ros.wiring import ARGUMENTS, wired

pytestmark = pytest.mark.ros


def nodes(**given):
    return {spec.executable: spec for spec in wired({'floorplan': 'plan.yaml', **given})}


def test_a_lidar_alone_is_its_own_odometry():
    found = nodes()
    assert set(found) == {'floorplan_server', 'odometry', 'localizer'}
    assert found['odometry'].parameters == found['localizer'].parameters == {}
    assert found['odometry'].remappings == {'pointcloud_topic': '/points'}
    named = nodes(odom_frame='odom', base_frame='base_link')
    assert named['odometry'].parameters == {'base_frame': 'base_link', 'lidar_odom_frame': 'odom'}
    assert named['localizer'].parameters == {'base_frame': 'base_link'}


def test_a_site_needs_no_floorplan_server():
    found = {spec.executable: spec for spec in wired({'site': 'site.yaml'})}
    assert set(found) == {'odometry', 'localizer'}
    assert found['localizer'].parameters == {'site': 'site.yaml'}


def test_another_localizer_is_initialized_by_a_seeder():
    found = nodes(hand_over='true', base_frame='base_link', namespace='robot_1')
    assert found['localizer'].parameters['hand_over'] is True
    assert found['seeder'].parameters == {'base_frame': 'base_link'}
    assert found['seeder'].remappings['/tf'] == 'tf'
    assert 'seeder' not in nodes(hand_over='false')
    found = nodes(hand_over='true', other_source='odometry', other_pose='/lio/odom')
    assert found['seeder'].parameters == {'other_source': 'odometry'}
    assert found['seeder'].remappings == {'amcl_pose': '/lio/odom'}


def test_an_imu_is_for_our_odometry():
    odometry = nodes(imu='/imu/data')['odometry']
    assert odometry.parameters == {'use_imu': True}
    assert odometry.remappings['imu'] == '/imu/data'


def test_beside_odometry_tf_of_the_robot_s_own_ours_keeps_out_of_tf():
    found = nodes(odom_frame='odom', base_frame='base_link', publish_odom_tf='false')
    parameters = found['odometry'].parameters
    assert parameters == {'base_frame': 'base_link', 'publish_odom_tf': False}
    assert found['localizer'].parameters == {'base_frame': 'base_link', 'odom_frame': 'odom'}


def test_the_robot_s_odometry_alone_needs_no_node_of_ours():
    found = nodes(odometry='robot', points='/lidar')
    assert set(found) == {'floorplan_server', 'localizer'}
    assert found['localizer'].parameters == {'odometry_source': 'tf', 'odom_frame': 'odom'}
    assert found['localizer'].remappings == {'kiss/frame': '/lidar'}
    found = nodes(odometry='robot', odom_topic='/odometry/filtered', scan='/front, /rear')
    assert found['localizer'].parameters == {'scan_topics': ['/front', '/rear']}
    assert found['localizer'].remappings['kiss/odometry'] == '/odometry/filtered'


def test_with_both_the_robot_s_is_the_one_in_tf():
    found = nodes(odometry='both')
    assert found['odometry'].parameters == {
        'publish_odom_tf': False, 'robot_odometry': 'tf', 'odom_frame': 'odom',
    }  # fmt: skip
    assert found['localizer'].parameters == {'odom_frame': 'odom'}
    found = nodes(odometry='both', odom_topic='/wheels', publish_odom_tf='true')
    assert found['odometry'].parameters == {'robot_odometry': 'topic'}
    assert found['odometry'].remappings['odom'] == '/wheels'
    assert found['localizer'].parameters == {}


def test_in_every_combination_one_node_at_most_publishes_the_base_s_parent():
    """Where ours publishes, the localizer's TF ends at ours; else at the robot's."""
    count = 0
    for odometry, odom_topic, odom_frame, publishes in product(
        ('kiss', 'robot', 'both'), ('', '/odom'), ('', 'odom'), ('', 'true', 'false')
    ):
        try:
            found = nodes(
                odometry=odometry,
                odom_topic=odom_topic,
                odom_frame=odom_frame,
                publish_odom_tf=publishes,
            )
        except ConfigError:
            continue
        count += 1
        is_ours = 'odometry' in found and found['odometry'].parameters.get('publish_odom_tf', True)
        ends_at = found['localizer'].parameters.get('odom_frame', '')
        if is_ours:
            assert not ends_at
        elif odometry != 'robot' or not odom_topic:
            assert ends_at == 'odom'
    assert count > 15


def test_in_a_namespace_tf_is_there_too_unless_it_is_shared():
    in_namespace = {'/tf': 'tf', '/tf_static': 'tf_static'}
    found = nodes(namespace='robot_1')
    for name in ('odometry', 'localizer'):
        assert in_namespace.items() <= found[name].remappings.items()
    found = nodes(namespace='robot_1', shared_tf='true')
    assert '/tf' not in found['localizer'].remappings


def test_a_map_of_somebody_else_s_needs_no_server():
    found = {spec.executable: spec for spec in wired({'map': '/map'})}
    assert 'floorplan_server' not in found
    assert found['localizer'].remappings['floorplan'] == '/map'


@pytest.mark.parametrize(
    ('given', 'message'),
    [
        ({}, 'site:=FILE; none is set'),
        ({'floorplan': 'a', 'map': '/map'}, 'floorplan and map is set'),
        ({'floorplan': 'a', 'site': 'b'}, 'floorplan and site is set'),
        ({'floorplan': 'a', 'odometry': 'false'}, 'choose kiss, robot or both'),
        ({'floorplan': 'a', 'odometry': 'robot', 'publish_odom_tf': 'true'}, 'needs our odometry'),
        ({'floorplan': 'a', 'odometry': 'both', 'publish_odom_tf': 'true'}, 'second parent'),
        ({'floorplan': 'a', 'odom_topic': '/odom'}, 'odometry:=robot or odometry:=both'),
        ({'floorplan': 'a', 'odometry': 'robot', 'imu': '/imu'}, 'our odometry only'),
        ({'floorplan': 'a', 'storey': 'two'}, 'storey:=two is not of type int'),
        ({'floorplan': 'a', 'autostart': 'yes'}, 'neither true nor false'),
    ],
)
def test_contradictions_end_in_one_line(given, message):
    with pytest.raises(ConfigError, match=message):
        wired(given)


def test_every_argument_is_read():
    """Setting it to something else makes other nodes, or is refused."""
    for name, _, _ in ARGUMENTS:
        if name in ('floorplan', 'shared_tf', 'publish_odom_tf', 'namespace'):
            continue  # see above
        for value in ('true', '2', 'end', '/x'):
            base = {'floorplan': 'a', 'odometry': 'both', 'odom_topic': '/o'}
            base |= {'floorplan': ''} if name == 'map' else {}
            base |= {'publish_odom_tf': 'false'} if name == 'odom_frame' else {}
            try:
                changed = wired({**base, name: value}) != wired({**base, 'floorplan': 'a'})
            except ConfigError:
                changed = True
            if changed:
                break
        assert changed, name
