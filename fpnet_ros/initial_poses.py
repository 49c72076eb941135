# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Somebody's word on where the robot is: by topic, by service, or by parameters at the start."""

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
"""Given: what AMCL takes for the doubt about the pose in its parameters."""


class InitialPose(Section):
    """Where the robot is when it starts, named as AMCL's."""

    x: float = Field(0.0, description='Where the robot is at the start, in map_frame [m].')
    y: float = Field(0.0, description='Where the robot is at the start, in map_frame [m].')
    yaw: float = Field(0.0, description='Its heading at the start [rad].')

    def in_frame(self, frame_id: str) -> UncertainPose:
        """Return the pose with AMCL's doubt about it."""
        pose = StampedPose(0, frame_id, SE2.from_xy_yaw(self.x, self.y, self.yaw))
        return UncertainPose(pose, np.diag(np.square([_SIGMA_M, _SIGMA_M, _SIGMA_RAD])))


class InitialPoses:
    """
    Hands words on to the localizer, in the executor's thread.

    One that comes before the first floorplan or scan, which it is counted from, waits for them;
    the newest counts.

    Parameters
    ----------
    situation
        Returns the frame of the floorplan and the newest scan, None while there is none.
    frame_named
        Returns the storey whose plan's frame is called so, and that frame; None where none is.
    suggest
        Takes the hint.
    logger
        The node's: what became of each word is told.
    first
        What parameters say.
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
        """Take a message; one that cannot be used is rejected with a line."""
        try:
            self.take(uncertain_pose_from_msg(msg), source)
        except FpnetError as error:
            self._reject(source, error)

    def take(self, given: UncertainPose, source: str) -> None:
        """Take a word; ``source`` names where it is from."""
        self._waiting = given, source
        self.follow()
        if self._waiting is not None:
            self._logger.info(f'{source} waits for the first floorplan and the first scan')

    def follow(self) -> None:
        """Use what waits, as soon as there are a floorplan and a scan."""
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
        self._logger.info('took the initial pose; it counts once the walls agree')

    def _reject(self, source: str, error: FpnetError) -> None:
        self._logger.warning(f'{source} was rejected: {one_line(error)}')
