# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Publishers of the localizer node; each method converts core values to messages."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Path
import numpy as np
from visualization_msgs.msg import MarkerArray

from fpnet_core.doctor import Finding
from fpnet_core.geometry import SE2
from fpnet_core.io.topic_names import TF_TOPIC
from fpnet_core.localizer.guidance import NextLook
from fpnet_core.localizer.localizer import Snapshot
from fpnet_core.localizer.map_frame import Located, MapFrame
from fpnet_core.raster.warping import warped_grid
from fpnet_core.types import GridMap, LocalizerOutput
from fpnet_ros.checkup import findings_to_msg
from fpnet_ros.inputs import LocatedScan
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.runtime import LATCHED, STATUS, STREAM, TF, TFMessage
from msg_adapters.diagnostics import LocalizerReport, diagnostics_to_msg, report_to_msg
from msg_adapters.grids import grid_to_msg
from msg_adapters.markers import (
    hypothesis_markers,
    markers_to_msg,
    match_markers,
    region_markers,
    way_markers,
)
from msg_adapters.poses import path_to_msg, pose_to_msg, uncertain_pose_to_msg
from msg_adapters.transforms import transform_to_msg

_PATH_LENGTH = 5000  # poses, 500 m at the default spacing; chosen


@dataclass(frozen=True, eq=False)
class StampedOutput:
    """
    Values that are published together: an output, frames of its floorplan and the newest scan.

    ``frame`` is None if the floorplan has been replaced since the output; ``look`` is where to
    look next, None while localized or if unknown.
    """

    snapshot: Snapshot
    frame: MapFrame | None
    scan: LocatedScan | None
    look: NextLook | None = None

    @classmethod
    def of(
        cls, snapshot: Snapshot, frame: MapFrame | None, scan: LocatedScan | None
    ) -> StampedOutput:
        """Combine them, without ``frame`` if that belongs to another floorplan."""
        plan = None if snapshot.plan is None else snapshot.plan.given
        return cls(snapshot, frame if frame is not None and frame.plan is plan else None, scan)

    @property
    def output(self) -> LocalizerOutput:
        """Output of the last update."""
        return self.snapshot.output

    @property
    def located(self) -> Located | None:
        """Pose of the robot at the scan, in every frame; None unless localized."""
        if self.frame is None or self.scan is None:
            return None
        return self.frame.located(self.output, self.scan.T_odom_base, self.scan.stamp_ns)


class LocalizerOutputs:
    """The publishers of one configured localizer node."""

    def __init__(self, node: ManagedNode, path_spacing_m: float) -> None:
        self._name = node.get_fully_qualified_name()
        self.path_spacing_m = path_spacing_m
        self._path: deque[Any] = deque(maxlen=_PATH_LENGTH)
        self._path_end: SE2 | None = None
        self._published_ns: int | None = None  # stamp of the last pose
        self._map_odom: tuple[Any, str, str] | None = None  # T_map_odom (4, 4) and its frames
        self.accepted: PoseWithCovarianceStamped | None = None
        """Last message on ``floorplan_pose_with_covariance``; None unless localized."""
        self._tf_stamp_ns = 0
        add = node.add_publisher
        self._pose = add(PoseStamped, 'floorplan_pose', STREAM)
        self._pose_cov = add(PoseWithCovarianceStamped, 'floorplan_pose_with_covariance', STATUS)
        self._path_publisher = add(Path, 'floorplan_path', LATCHED)
        self._status = add(DiagnosticStatus, '~/status', STATUS)
        self._diagnostics = add(DiagnosticArray, '/diagnostics', STREAM)
        self._markers = add(MarkerArray, '~/markers', LATCHED)
        self._goal = add(PoseStamped, '~/next_look', STREAM)
        self._submap = add(OccupancyGrid, '~/submap', LATCHED)
        self._scaled = add(OccupancyGrid, '~/floorplan_scaled', LATCHED)
        self._tf = add(TFMessage, TF_TOPIC, TF) if TFMessage else None

    def forget_path(self) -> None:
        """Start a new path, after the floorplan was replaced."""
        self._path.clear()
        self._path_end = None

    def forget_pose(self) -> None:
        """Stop broadcasting until there is a pose again."""
        self._map_odom = self.accepted = None

    def publish_pose(self, moment: StampedOutput) -> None:
        """
        Publish the pose at the newest scan once and set the TF; forget both unless localized.

        ``floorplan_pose`` is in the floorplan grid's frame and nominal metres, the pose with
        covariance in ``map``.
        """
        scan, frame, located = moment.scan, moment.frame, moment.located
        if scan is None or frame is None or located is None:
            self.forget_pose()
            return
        sensor_pose, stamp_ns = scan.sensor_pose, scan.stamp_ns
        T_map_tf = located.T_map_odom.as_matrix4() @ np.linalg.inv(sensor_pose.T_tf_odom)
        self._map_odom = T_map_tf, frame.map_id, sensor_pose.tf_frame
        if stamp_ns == self._published_ns:
            return
        self._published_ns, pose, end = stamp_ns, located.T_plan_base, self._path_end
        msg = pose_to_msg(pose, stamp_ns, frame.plan_id)
        self._pose.publish(msg)
        if end is None or np.hypot(*(pose.translation - end.translation)) >= self.path_spacing_m:
            self._path.append(msg)
            self._path_end = pose
        if located.cov is not None:
            self.accepted = uncertain_pose_to_msg(
                located.T_map_base, located.cov, stamp_ns, frame.map_id
            )
            self._pose_cov.publish(self.accepted)

    def broadcast(self, stamp_ns: int) -> None:
        """Broadcast the TF, once per stamp, because tf2 warns about repeated stamps."""
        if self._tf is None or self._map_odom is None or stamp_ns == self._tf_stamp_ns:
            return
        self._tf_stamp_ns = stamp_ns
        T_map_odom, map_frame, odom_frame = self._map_odom
        transform = transform_to_msg(T_map_odom, stamp_ns, map_frame, odom_frame)
        self._tf.publish(TFMessage(transforms=[transform]))

    def publish_tick(self, moment: StampedOutput) -> None:
        """Publish path, goal, submap and markers of an update, if subscribed."""
        frame, output, scan = moment.frame, moment.output, moment.scan
        if frame is None:
            return
        if output.A_plan_odom is not None and self._path_publisher.get_subscription_count():
            # A copy: the thread that adds scans may add a pose meanwhile.
            path = path_to_msg(list(self._path), output.stamp_ns, frame.plan_id)
            self._path_publisher.publish(path)
        if scan is None:
            return
        # Of the odometry frame in TF, which need not be KISS-ICP's.
        tf_frame = scan.sensor_pose.tf_frame
        T_tf_odom = SE2.from_matrix4(scan.sensor_pose.T_tf_odom)
        way = None if moment.look is None else T_tf_odom.apply(moment.look.way_odom)
        if way is not None:  # a goal that faces along the path to it
            (x, y), ahead = way[-1].tolist(), way[-1] - way[max(-2, -len(way))]
            goal = SE2.from_xy_yaw(x, y, math.atan2(ahead[1], ahead[0]))
            self._goal.publish(pose_to_msg(goal, output.stamp_ns, tf_frame))
        submap = output.submap
        if submap is not None and self._submap.get_subscription_count():
            at = T_tf_odom @ submap.T_odom_submap @ submap.grid.T_frame_grid
            grid = GridMap(submap.grid.cells, submap.grid.resolution, at, 'odom')
            self._submap.publish(grid_to_msg(grid, submap.stamp_ns, tf_frame))
        if self._markers.get_subscription_count():
            markers = _markers_of(moment, frame, scan, T_tf_odom)
            if way is not None:
                markers += way_markers(way, output.stamp_ns, tf_frame)
            self._markers.publish(markers_to_msg(markers))

    def publish_status(self, report: LocalizerReport) -> None:
        """Publish the status of the last update."""
        self._status.publish(report_to_msg(report, self._name))

    def publish_diagnostics(
        self, report: LocalizerReport, findings: Sequence[Finding], stamp_ns: int
    ) -> None:
        """Publish the node's health and findings on ``/diagnostics``."""
        health = report_to_msg(report, f'{self._name}: localization')
        wiring = findings_to_msg(self._name, findings)
        self._diagnostics.publish(diagnostics_to_msg([health, wiring], stamp_ns))

    def publish_scaled(self, frame: MapFrame, stamp_ns: int) -> None:
        """Publish the floorplan at its true scale, in ``map``."""
        grid = warped_grid(frame.plan, frame.A_map_plan)
        self._scaled.publish(grid_to_msg(grid, stamp_ns, frame.map_id))


def _markers_of(
    moment: StampedOutput, frame: MapFrame, scan: LocatedScan, T_tf_odom: SE2
) -> list[Any]:
    """Return rooms, doors, edges, matches and hypotheses as markers."""
    output, plan, A_map_plan = moment.output, moment.snapshot.plan, frame.A_map_plan
    stamp_ns, map_frame, markers = output.stamp_ns, frame.map_id, []
    if plan is not None:
        rooms, graph = plan.nominal.segmentation, plan.nominal.graph
        markers += region_markers(rooms, graph, A_map_plan, stamp_ns, map_frame, 'plan')
        markers += match_markers(graph, output, A_map_plan, stamp_ns, map_frame)
    if output.submap is not None and output.segmentation is not None:
        T_odom_submap, tf_frame = output.submap.T_odom_submap, scan.sensor_pose.tf_frame
        rooms, graph, T_tf_submap = output.segmentation, output.graph, T_tf_odom @ T_odom_submap
        markers += region_markers(rooms, graph, T_tf_submap, stamp_ns, tf_frame, 'submap')
        T_submap_base = T_odom_submap.inv() @ SE2.from_matrix4(scan.T_odom_base)
        markers += hypothesis_markers(
            output.estimates, A_map_plan, T_submap_base, stamp_ns, map_frame
        )
    return markers
