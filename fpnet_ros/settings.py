# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the localizer node, and which of all keys may change at any time."""

from __future__ import annotations

from pydantic import Field

from fpnet_core.config import LocalizerConfig
from fpnet_core.config_docs import config_fields
from fpnet_ros.initial_poses import InitialPose
from fpnet_ros.inputs import InputParameters
from fpnet_ros.runtime import STALE_INPUT_S
from msg_adapters.poses import UncertainPose


class LocalizerParameters(InputParameters):
    """Parameters of the localizer node outside the configuration tree."""

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
        """Hint from the parameters, None if unset."""
        return self.initial_pose.in_frame(self.map_frame) if self.set_initial_pose else None

    @property
    def sends_tf(self) -> bool:
        """Whether this node publishes the transform to odometry."""
        return self.tf_broadcast and not self.hand_over


LIVE = (
    'tf_broadcast',
    'transform_tolerance',
    'tf_rate_hz',
    'scan_timeout_s',
    'stale_input_s',
    'path_spacing_m',
)
"""Parameters that may change at any time."""

_READ_ONCE = ('scorer_weights', 'plan_prior', 'match_probability')

LIVE_CONFIG = tuple(
    field.key
    for field in config_fields(LocalizerConfig, 'localizer.')
    if field.key.removeprefix('localizer.') not in _READ_ONCE
)
"""Keys of the configuration tree that may change at any time, as every update reads them."""
