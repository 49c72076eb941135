# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Coordination of the localizer node's publishers: values that belong together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from threading import Lock
from typing import Any

from fpnet_core.config import ScalePolicy
from fpnet_core.doctor import Finding
from fpnet_core.errors import FpnetError
from fpnet_core.localizer.guidance import NextLook, next_look
from fpnet_core.localizer.localizer import Snapshot
from fpnet_core.localizer.map_frame import MapFrame
from fpnet_core.sites.site_localizer import SiteLocalizer
from fpnet_core.stamps import NS_PER_S
from fpnet_ros.floorplans import ServedPlan
from fpnet_ros.health import Health
from fpnet_ros.inputs import LocatedScan
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.logs import NodeLog, one_line
from fpnet_ros.outputs import LocalizerOutputs, StampedOutput
from fpnet_ros.settings import LocalizerParameters
from fpnet_ros.storeys import StoreyTopics
from msg_adapters.diagnostics import LocalizerReport


class StatusPublisher:
    """
    Publishes a localizer's results while its node is active; may be called from any thread.

    Parameters
    ----------
    node
        Owner of the topics, with clock, log and whether it is active.
    localizer
        Localizer whose results are published.
    out, storeys
        The publishers.
    health
        Health to publish with the status.
    settings
        Returns the current parameters of the node.
    log
        Gets a line about each change of the status.

    Attributes
    ----------
    frame
        Frames of the floorplan, None until there is one.
    newest
        Scan that was added last, None before the first.
    told
        Report of the last update, None before the first.
    """

    def __init__(
        self,
        node: ManagedNode,
        localizer: SiteLocalizer,
        out: LocalizerOutputs,
        storeys: StoreyTopics,
        health: Health,
        settings: Callable[[], LocalizerParameters],
        log: NodeLog,
    ) -> None:
        self._node, self._localizer = node, localizer
        self._out, self._storeys, self._health = out, storeys, health
        self._settings, self._log = settings, log
        self._lock = Lock()
        self.frame: MapFrame | None = None
        self.newest: LocatedScan | None = None
        self.told: LocalizerReport | None = None
        self._shown: MapFrame | None = None
        # Where to look next, computed once for each snapshot.
        self._look: tuple[Snapshot | None, NextLook | None] = None, None

    @property
    def accepted(self) -> Any:
        """The current PoseWithCovarianceStamped, None unless localized."""
        return None if self._health.is_starved else self._out.accepted

    def situation(self) -> tuple[MapFrame | None, LocatedScan | None]:
        """Return the frames and the scan to which an initial pose refers."""
        return self.frame, self.newest

    def scan(self, scan: LocatedScan) -> None:
        """Publish the pose at a scan that was just added."""
        self.newest = scan
        self._health.saw_scan(self._now_ns())
        self._publish_stamped()

    def update(self) -> None:
        """Publish pose, status and the other results of an update."""
        changed = self._storeys.follow(self._localizer.snapshot)
        if changed is not None:
            self._out.forget_path()
            self._show(changed)
        frame, A_plan_odom = self.frame, self._localizer.output.A_plan_odom
        if frame is not None:
            self._show(frame if A_plan_odom is None else frame.followed(A_plan_odom))
        of, look = self._next_look(self._localizer.snapshot)
        stamped = self._publish_stamped()  # the update may have located the newest scan
        report = self._health.report(stamped.output, self._settings().stale_input_s)
        report = self._storeys.noted(report)
        if of is stamped.snapshot and look is not None and not self._health.is_starved:
            stamped = replace(stamped, look=look)
            report = replace(report, look=look.words)
        self.told = report
        self._log.status(report)
        self._out.publish_status(report)
        self._out.publish_tick(stamped)

    def differences(self) -> None:
        """Publish where the drawing is out of date."""
        self._storeys.publish_differences(self._localizer.snapshot, self.frame)

    def floorplan(self, plan: ServedPlan, policy: ScalePolicy) -> None:
        """Pass a floorplan to the localizer; if that refuses it, the old one stays."""
        try:
            plan.give_to(self._localizer, policy)
        except FpnetError as error:
            self._node.get_logger().error(one_line(error))
            return
        self._out.forget_path()
        said = f'received the floorplan in frame {plan.frame_id}{plan.said_of_scale}'
        self._node.get_logger().info(said)
        self._show(MapFrame(plan.grid, plan.frame_id, self._settings().map_frame))
        self.update()

    def transform(self) -> None:
        """Broadcast post-dated TF while scans arrive; publish when they stop or resume."""
        settings, now_ns = self._settings(), self._now_ns()
        if self._node.is_active and self._health.has_turned(now_ns, settings.scan_timeout_s):
            self.update()
        if settings.sends_tf and now_ns and not self._health.is_starved:
            self._out.broadcast(now_ns + round(settings.transform_tolerance * NS_PER_S))

    def diagnostics(self, findings: Sequence[Finding]) -> None:
        """Publish the health of the node and its findings."""
        news = self._health.news(self._localizer.output, self._settings().stale_input_s)
        self._out.publish_diagnostics(self._storeys.noted(news), findings, self._now_ns())

    def stop(self) -> None:
        """Forget the pose, so that nothing is published any more."""
        with self._lock:
            self._out.forget_pose()

    def _next_look(self, snapshot: Snapshot) -> tuple[Snapshot | None, NextLook | None]:
        scan = self.newest
        if self._look[0] is not snapshot:
            look = None
            if snapshot.plan is not None and scan is not None:
                drawn = snapshot.plan.nominal.evidence
                look = next_look(drawn, snapshot.output, scan.T_odom_base)
            self._look = snapshot, look
        return self._look

    def _publish_stamped(self) -> StampedOutput:
        """Publish the pose from the current values, and return those."""
        with self._lock:  # so that threads publish in the order of their values
            stamped = StampedOutput.of(self._localizer.snapshot, self.frame, self.newest)
            if self._node.is_active:
                self._out.publish_pose(stamped)
        return stamped

    def _show(self, frame: MapFrame) -> None:
        """Set the frame ``map``; publish the floorplan in it if it has changed."""
        self.frame = frame
        # An inactive node's publishers drop messages: its floorplan is published on activation.
        if frame is not self._shown and self._node.is_active:
            self._shown = frame
            self._out.publish_scaled(frame, self._now_ns())

    def _now_ns(self) -> int:
        return self._node.get_clock().now().nanoseconds
