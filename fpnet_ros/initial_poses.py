# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pose hints from a topic, a service, or parameters at the start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from geometry_msgs.msg import PoseWithCovarianceStamped
import numpy as np
from pydantic import Field

from fpnet_core.config import Section
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.map_frame import MapFrame
from fpnet_ros.inputs import LocatedScan
from fpnet_ros.runtime import one_line
from msg_adapters.poses import StampedPose, UncertainPose, uncertain_pose_from_msg

_SIGMA_M, _SIGMA_RAD = 0.5, np.pi / 12.0
"""Given: AMCL's standard deviations of the initial pose in its parameters."""


class InitialPose(Section):
    """Pose of the robot at the start; names as in AMCL."""

    x: float = Field(0.0, description='Position at the start, in map_frame [m].')
    y: float = Field(0.0, description='Position at the start, in map_frame [m].')
    yaw: float = Field(0.0, description='Heading at the start, in map_frame [rad].')

    def in_frame(self, frame_id: str) -> UncertainPose:
        """Return the pose with AMCL's default covariance."""
        pose = StampedPose(0, frame_id, SE2.from_xy_yaw(self.x, self.y, self.yaw))
        return UncertainPose(pose, np.diag(np.square([_SIGMA_M, _SIGMA_M, _SIGMA_RAD])))


class InitialPoses:
    """
    Passes pose hints to the localizer, in the executor's thread.

    A hint refers to a floorplan and a scan. Before the first ones it waits; a newer hint replaces
    it.

    Parameters
    ----------
    situation
        Returns the floorplan's frames and the newest scan, each None if there is none yet.
    frame_named
        Returns storey and frames for the frame of a storey's plan; None for other frames.
    suggest
        Passes a hint to the localizer.
    logger
        The node's logger; it gets a line about each hint.
    first
        Hint from the parameters, if any.
    """

    def __init__(
        self,
        situation: Callable[[], tuple[MapFrame | None, LocatedScan | None]],
        frame_named: Callable[[str], tuple[str, MapFrame] | None],
        suggest: Callable[[PoseHint], None],
        logger: Any,
        first: UncertainPose | None = None,
    ) -> None:
        self._situation, self._frame_named = situation, frame_named
        self._suggest, self._logger = suggest, logger
        self._waiting = None if first is None else (first, 'parameter initial_pose')

    def on_message(self, msg: PoseWithCovarianceStamped, source: str = 'initialpose') -> None:
        """Take a hint from a message; log and ignore an unusable one."""
        try:
            self.take(uncertain_pose_from_msg(msg), source)
        except FpnetError as error:
            self._reject(source, error)

    def take(self, given: UncertainPose, source: str) -> None:
        """Take a hint; ``source`` is its name in the log."""
        self._waiting = given, source
        self.follow()
        if self._waiting is not None:
            self._logger.info(f'{source} waits for the first floorplan and the first scan')

    def follow(self) -> None:
        """Use a waiting hint once there are a floorplan and a scan."""
        if self._waiting is None:
            return
        given, source = self._waiting
        pose, (frame, scan) = given.pose, self._situation()
        storey, frame = self._frame_named(pose.frame_id) or ('', frame)
        if frame is None or scan is None:
            return
        self._waiting = None
        try:
            hint = frame.hint(pose.T_frame_body, pose.frame_id, given.cov, scan.T_odom_base)
        except FpnetError as error:
            self._reject(source, error)
            return
        self._suggest(replace(hint, storey=storey))
        self._logger.info('received the initial pose; it takes effect once scans confirm it')

    def _reject(self, source: str, error: FpnetError) -> None:
        self._logger.warning(f'{source} was rejected: {one_line(error)}')
