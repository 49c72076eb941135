# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the localizer node publishes: each method puts core values into messages."""

from __future__ import annotations

from collections import deque
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Path
import numpy as np
from numpy.typing import NDArray
from visualization_msgs.msg import MarkerArray

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.pose import MapSide
from fpnet_core.types import GridMap, LocalizerOutput
from fpnet_ros.inputs import TFMessage
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.runtime import LATCHED, STATUS, STREAM, TF
from msg_adapters.diagnostics import LocalizerReport, diagnostics_to_msg, report_to_msg
from msg_adapters.grids import grid_to_msg
from msg_adapters.markers import (
    hypothesis_markers,
    markers_to_msg,
    match_markers,
    region_markers,
)
from msg_adapters.poses import path_to_msg, pose_to_msg, uncertain_pose_to_msg
from msg_adapters.transforms import transform_to_msg

_PATH_LENGTH = 5000  # poses; at the default spacing half a kilometre; chosen


class LocalizerOutputs:
    """The publishers of one configured localizer node."""

    def __init__(self, node: ManagedNode, map_frame: str, path_spacing_m: float) -> None:
        self._name = node.get_fully_qualified_name()
        self._map_frame = map_frame
        self._path_spacing_m = path_spacing_m
        self._path: deque[Any] = deque(maxlen=_PATH_LENGTH)
        self._path_end: SE2 | None = None
        add = node.add_publisher
        self._pose = add(PoseStamped, 'floorplan_pose', STREAM)
        self._twin = add(PoseWithCovarianceStamped, 'floorplan_pose_with_covariance', STREAM)
        self._path_publisher = add(Path, 'floorplan_path', LATCHED)
        self._status = add(DiagnosticStatus, '~/status', STATUS)
        self._diagnostics = add(DiagnosticArray, '/diagnostics', STREAM)
        self._markers = add(MarkerArray, '~/markers', LATCHED)
        self._submap = add(OccupancyGrid, '~/submap', LATCHED)
        self._scaled = add(OccupancyGrid, '~/floorplan_scaled', LATCHED)
        self._tf = add(TFMessage, '/tf', TF) if TFMessage else None

    def forget_path(self) -> None:
        """Begin a new path: the floorplan was replaced."""
        self._path.clear()
        self._path_end = None

    def publish_pose(self, pose: SE2, stamp_ns: int, plan_frame: str) -> None:
        """Publish the pose in the floorplan grid's own frame and nominal metres."""
        msg = pose_to_msg(pose, stamp_ns, plan_frame)
        self._pose.publish(msg)
        end = self._path_end
        if end is None or np.hypot(*(pose.translation - end.translation)) >= self._path_spacing_m:
            self._path.append(msg)
            self._path_end = pose

    def publish_twin(self, pose: SE2, cov: NDArray[np.float64], stamp_ns: int) -> None:
        """Publish the pose in ``map`` with its covariance."""
        self._twin.publish(uncertain_pose_to_msg(pose, cov, stamp_ns, self._map_frame))

    def publish_path(self, stamp_ns: int, plan_frame: str) -> None:
        """Publish the poses so far, in the floorplan grid's frame."""
        if self._path_publisher.get_subscription_count():
            self._path_publisher.publish(path_to_msg(self._path, stamp_ns, plan_frame))

    def publish_tf(self, T_map_odom: NDArray[np.float64], stamp_ns: int, odom_frame: str) -> None:
        """Broadcast ``map`` to ``odom``; nothing where TF's message is not installed."""
        if self._tf is not None:
            transform = transform_to_msg(T_map_odom, stamp_ns, self._map_frame, odom_frame)
            self._tf.publish(TFMessage(transforms=[transform]))

    def publish_status(self, report: LocalizerReport) -> None:
        """Publish what the last tick said."""
        self._status.publish(report_to_msg(report, self._name))

    def publish_diagnostics(self, report: LocalizerReport, stamp_ns: int) -> None:
        """Publish the node's health for the robot's monitor."""
        msg = report_to_msg(report, f'{self._name}: localization')
        self._diagnostics.publish(diagnostics_to_msg([msg], stamp_ns))

    def publish_scaled(self, grid: GridMap, stamp_ns: int) -> None:
        """Publish the floorplan at its true scale, in ``map``."""
        self._scaled.publish(grid_to_msg(grid, stamp_ns, self._map_frame))

    def publish_submap(self, output: LocalizerOutput, odom_frame: str) -> None:
        """Publish what the robot has seen so far, if anyone listens."""
        submap = output.submap
        if submap is None or not self._submap.get_subscription_count():
            return
        grid = GridMap(
            submap.grid.cells,
            submap.grid.resolution,
            submap.T_odom_submap @ submap.grid.T_frame_grid,
            'odom',
        )
        self._submap.publish(grid_to_msg(grid, submap.stamp_ns, odom_frame))

    def publish_markers(
        self,
        plan: MapSide | None,
        output: LocalizerOutput,
        A_map_plan: Affine2D,
        odom_frame: str,
        T_odom_base: SE2 | None,
    ) -> None:
        """Publish rooms, doors, edges, matches and hypotheses, if anyone listens."""
        if not self._markers.get_subscription_count():
            return
        stamp_ns, markers = output.stamp_ns, []
        if plan is not None:
            segmentation, graph = plan.segmentation, plan.graph
            markers += region_markers(
                segmentation, graph, A_map_plan, stamp_ns, self._map_frame, 'plan'
            )
            markers += match_markers(graph, output, A_map_plan, stamp_ns, self._map_frame)
        if output.submap is not None and output.segmentation is not None:
            T_odom_submap = output.submap.T_odom_submap
            markers += region_markers(
                output.segmentation, output.graph, T_odom_submap, stamp_ns, odom_frame, 'submap'
            )
            if T_odom_base is not None:
                T_submap_base = T_odom_submap.inv() @ T_odom_base
                markers += hypothesis_markers(
                    output.estimates, A_map_plan, T_submap_base, stamp_ns, self._map_frame
                )
        self._markers.publish(markers_to_msg(markers))
