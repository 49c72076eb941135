# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Parameters of all nodes outside the configuration tree; imports no ROS.

``python -m fpnet_ros.settings`` writes the documented parameter file, ``config/fpnet.yaml``. Keys
of the configuration tree have their defaults there. Those of this module are in comments, so that
the command line can read the same file and nodes keep their own defaults.
"""

from __future__ import annotations

import sys
from typing import Literal

import numpy as np
from pydantic import Field

from fpnet_core.config import FpnetConfig, LocalizerConfig, Section
from fpnet_core.config_docs import config_fields, render_section, render_yaml
from fpnet_core.geometry import SE2
from msg_adapters.poses import StampedPose, UncertainPose

STALE_INPUT_S = 3.0
"""Numerical: an input silent for longer is missing; sensors publish ten times a second."""

_SIGMA_M, _SIGMA_RAD = 0.5, np.pi / 12.0
"""Given: AMCL's standard deviations of the initial pose in its parameters."""


class LifecycleParameters(Section):
    """Parameters of the start of a lifecycle node."""

    autostart: bool = Field(
        True, description='Configure and activate at the start, without a lifecycle manager.'
    )


class LaserParameters(Section):
    """Topics of planar scanners."""

    scan_topics: tuple[str, ...] = Field(
        (), description='LaserScan topics to merge and use instead of clouds; empty: clouds.'
    )
    multi_echo_topics: tuple[str, ...] = Field(
        (), description='The same for MultiEchoLaserScan; the nearest echo is used.'
    )


class InputParameters(LaserParameters):
    """Sources of the localizer's scans and their poses."""

    odometry_source: Literal['topic', 'tf'] = Field(
        'topic', description='Source of poses: the topic kiss/odometry, or odom_frame in TF.'
    )
    odom_frame: str = Field(
        '',
        description='Child of the published transform, if the robot has its own TF tree; empty: '
        'the frame of the odometry messages.',
    )
    base_frame: str = Field(
        '', description='Frame to localize; empty: the child frame of the odometry.'
    )
    max_pending_scans: int = Field(
        10, ge=1, le=1000, description='Number of scans that may wait; the oldest are dropped.'
    )


class InitialPose(Section):
    """Pose of the robot at the start; names as in AMCL."""

    x: float = Field(0.0, description='Position at the start, in map_frame [m].')
    y: float = Field(0.0, description='Position at the start, in map_frame [m].')
    yaw: float = Field(0.0, description='Heading at the start, in map_frame [rad].')


class LocalizerParameters(InputParameters):
    """Parameters of the localizer."""

    site: str = Field(
        '',
        description='site.yaml, folder of maps or Open-RMF *.building.yaml with all floors; '
        'empty: the floorplan is received as a message.',
    )
    map_frame: str = Field('map', description='Frame of the floorplan at its true scale.')
    tf_broadcast: bool = Field(True, description='Publish TF from map_frame to odometry.')
    hand_over: bool = Field(
        False,
        description='Leave TF, initialpose and the services with the names of AMCL to another '
        'localizer, which the seeder initializes.',
    )
    set_initial_pose: bool = Field(False, description='Use initial_pose as a hint at the start.')
    initial_pose: InitialPose = InitialPose()
    transform_tolerance: float = Field(
        0.5, ge=0.0, le=10.0, description='TF is post-dated by this much [s].'
    )
    scan_timeout_s: float = Field(
        1.0,
        gt=0.0,
        description='Time without a located scan until TF stops and the status is waiting.',
    )
    tf_rate_hz: float = Field(25.0, ge=1.0, le=200.0, description='Rate of TF.')
    path_spacing_m: float = Field(
        0.1, ge=0.0, description='Distance between poses of floorplan_path.'
    )
    stale_input_s: float = Field(
        STALE_INPUT_S,
        gt=0.0,
        description='Silence of an input after which log and diagnostics warn.',
    )
    state_file: str = Field(
        '', description='File of the saved state, restored at the start; empty: none.'
    )
    autosave_period_s: float = Field(
        0.0, ge=0.0, description='Time between two saves; 0: only on request and at the end.'
    )
    run_dir: str = Field('', description='Folder for a file per update; empty: none.')

    @property
    def first_pose(self) -> UncertainPose | None:
        """Hint from the parameters with AMCL's default covariance, None if unset."""
        if not self.set_initial_pose:
            return None
        at = self.initial_pose
        pose = StampedPose(0, self.map_frame, SE2.from_xy_yaw(at.x, at.y, at.yaw))
        return UncertainPose(pose, np.diag(np.square([_SIGMA_M, _SIGMA_M, _SIGMA_RAD])))

    @property
    def sends_tf(self) -> bool:
        """Whether this node publishes the transform to odometry."""
        return self.tf_broadcast and not self.hand_over


class OdometryParameters(LaserParameters):
    """Parameters of the odometry, named as in KISS-ICP's node."""

    robot_odometry: Literal['none', 'topic', 'tf'] = Field(
        'none',
        description="The robot's own odometry, as initial guess and check of each registration: "
        'none, from the topic odom, or from odom_frame in TF.',
    )
    odom_frame: str = Field('', description="Frame of the robot's own odometry in TF.")
    base_frame: str = Field(
        '',
        description='Frame whose pose is published; empty: the root of the sensor in '
        '/tf_static, else the sensor.',
    )
    lidar_odom_frame: str = Field('odom_lidar', description='Frame of the published odometry.')
    publish_odom_tf: bool = Field(
        True,
        description='Publish the odometry as TF as well; false if the robot has its own.',
    )
    invert_odom_tf: bool = Field(
        False, description='Publish TF from the moving frame to the odometry frame.'
    )
    position_covariance: float = Field(
        0.1, ge=0.0, description='Variance of the position in the messages [m^2].'
    )
    orientation_covariance: float = Field(
        0.1, ge=0.0, description='Variance of the orientation in the messages [rad^2].'
    )
    use_imu: bool = Field(
        False, description='Take rotations between sweeps from the gyroscope on the topic imu.'
    )
    max_pending_scans: int = Field(
        10, ge=1, le=1000, description='Number of clouds that may wait; the oldest are dropped.'
    )


class FloorplanServerParameters(Section):
    """Parameters of the floorplan server: the file to publish and its frame."""

    floorplan: str = Field(
        '', description='Map YAML of map_server, or a drawing: image, PDF, SVG, DXF.'
    )
    resolution_m: float = Field(
        0.0, ge=0.0, description='Metres per pixel of a drawing; 0: as stated, or estimated.'
    )
    storey: int = Field(0, ge=0, description='Floor on the sheet, from 1; 0: the largest.')
    page: int = Field(0, ge=0, description='Page of a PDF, from 1; 0: the likeliest one.')
    length: tuple[float, ...] = Field(
        (), description='X1, Y1, X2, Y2 [pixels] of the drawing, and their distance [m]: a scale.'
    )
    crop: tuple[int, ...] = Field(
        (), description='Left, top, right and bottom [pixels] of the part to read; empty: all.'
    )
    layers: tuple[str, ...] = Field(
        (), description='Layers of a DXF, SVG or PDF with walls; empty: chosen automatically.'
    )
    mirrored: bool = Field(False, description='Flip the drawing: it is a mirror image.')
    frame_id: str = Field('floorplan', description='Frame of the published grid.')


class SeederParameters(Section):
    """Parameters of the seeder: the other localizer, and limits of the decisions."""

    reseed: bool = Field(
        True,
        description='Publish the pose again when the other localizer is elsewhere or unsure; '
        'false: only say so.',
    )
    elsewhere_s: float = Field(
        3.0,
        gt=0.0,
        description='Time for which the other localizer must be elsewhere before the pose is '
        'published again; doubled with each pose that it ignores.',
    )
    tolerance_m: float = Field(
        0.25,
        gt=0.0,
        description='Standard deviation of position between the maps of both localizers, and of '
        'a pose without covariance [m].',
    )
    tolerance_rad: float = Field(
        0.09, gt=0.0, description='Standard deviation of heading, likewise [rad].'
    )
    unsure_m: float = Field(
        1.5,
        gt=0.0,
        description='A pose with a larger standard deviation of position is unsure: ours is not '
        "published, the other localizer's is replaced [m].",
    )
    other_source: Literal['pose_with_covariance', 'pose', 'odometry', 'tf'] = Field(
        'pose_with_covariance',
        description='Pose of the other localizer: type of the topic amcl_pose, or TF from '
        'map_frame to base_frame.',
    )
    map_frame: str = Field('map', description='Frame of both poses.')
    base_frame: str = Field('base_link', description='Frame of the robot in TF.')


class ReplayParameters(Section):
    """Parameters of the replay."""

    bag: str = Field('', description='Folder of the bag, or its .db3 or .mcap file.')
    topics: tuple[str, ...] = Field((), description='Topics to play; empty plays all.')
    rate: float = Field(1.0, gt=0.0, le=100.0, description='Recorded seconds per second.')
    start_offset_s: float = Field(0.0, ge=0.0, description='Time to skip at the start.')
    loop: bool = Field(False, description='Repeat the recording; stamps and /clock then go back.')
    clock: bool = Field(False, description='Publish the recorded time on /clock.')
    wait_for_subscriber_s: float = Field(
        10.0, ge=0.0, description='Wait up to this long for the first subscriber.'
    )
    wait_for_localizer: bool = Field(
        False,
        description='Within wait_for_subscriber_s, wait for a localizer with a floorplan, and for '
        'subscribers of all topics of scans.',
    )
    max_ahead: int = Field(
        0, ge=0, description='Pause while kiss/odometry is this many scans behind; 0: never.'
    )


LIVE = (
    'tf_broadcast',
    'transform_tolerance',
    'tf_rate_hz',
    'scan_timeout_s',
    'stale_input_s',
    'path_spacing_m',
)
"""The localizer's parameters that may change at any time."""

_READ_ONCE = ('scorer_weights', 'plan_prior', 'match_probability')

LIVE_CONFIG = tuple(
    field.key
    for field in config_fields(LocalizerConfig, 'localizer.')
    if field.key.removeprefix('localizer.') not in _READ_ONCE
)
"""Keys of the configuration tree that may change at any time, as every update reads them."""

SECTIONS: dict[str, type[Section]] = {
    'localizer': LocalizerParameters,
    'odometry': OdometryParameters,
    'floorplan_server': FloorplanServerParameters,
    'localizer and floorplan_server': LifecycleParameters,
    'replay': ReplayParameters,
    'seeder': SeederParameters,
}
"""Sections of this module by the nodes that read them."""


def known_parameters() -> set[str]:
    """Return the names of all parameters of all nodes: one file may configure all of them."""
    return {
        field.key
        for section in (FpnetConfig, *SECTIONS.values())
        for field in config_fields(section)
    }


_HEAD = """\
    # Parameters of the nodes only, with defaults. Delete the first "# " of those that you set, in
    # a file for the nodes: fpnet localize --config refuses these keys.
"""


def render_parameter_file() -> str:
    """Return ``config/fpnet.yaml``."""
    lines = [
        f'    # {line}'.rstrip()
        for nodes, section in SECTIONS.items()
        for line in ('', f'## {nodes}', *render_section(section, section(), ''))
    ]
    return render_yaml() + _HEAD + '\n'.join(lines) + '\n'


if __name__ == '__main__':
    sys.stdout.write(render_parameter_file())
