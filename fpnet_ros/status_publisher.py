# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When the localizer node says what: which frames hold, what belongs to one moment."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
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
from fpnet_ros.outputs import LocalizerOutputs, StampedOutput
from fpnet_ros.runtime import StatusLog, one_line
from fpnet_ros.settings import LocalizerParameters
from fpnet_ros.storeys import StoreyTopics
from msg_adapters.diagnostics import LocalizerReport


@dataclass(frozen=True, eq=False)
class _Looked:
    """Where to look next, and the snapshot that tells it."""

    of: Snapshot
    at: NextLook | None


class StatusPublisher:
    """
    Publishes what a localizer knows while its node is active; may be called from any thread.

    Parameters
    ----------
    node
        Of the topics: its clock, its log, and whether it is active.
    localizer
        Whose state is told.
    out, storeys
        The publishers.
    health
        What is told beside.
    settings
        Returns the node's parameters as they are now.
    """

    def __init__(
        self,
        node: ManagedNode,
        localizer: SiteLocalizer,
        out: LocalizerOutputs,
        storeys: StoreyTopics,
        health: Health,
        settings: Callable[[], LocalizerParameters],
    ) -> None:
        self._node, self._localizer = node, localizer
        self._out, self._storeys, self._health = out, storeys, health
        self._settings = settings
        self._statuses = StatusLog(node.get_logger().info, node.get_logger().warning)
        self._lock = Lock()
        self.frame: MapFrame | None = None
        """Frames of the floorplan, None until there is one."""
        self.newest: LocatedScan | None = None
        """The scan that was added last, None before the first."""
        self.told: LocalizerReport | None = None
        """What the last tick said, None before the first."""
        self._looked: _Looked | None = None

    @property
    def claimed(self) -> Any:
        """The PoseWithCovarianceStamped that holds now, None where nothing is claimed."""
        return None if self._health.is_starved else self._out.claimed

    def situation(self) -> tuple[MapFrame | None, LocatedScan | None]:
        """Return what an initial pose is counted from."""
        return self.frame, self.newest

    def scan(self, scan: LocatedScan) -> None:
        """Tell where the robot is at a scan that was just added."""
        self.newest = scan
        self._health.saw_scan(self._now_ns())
        self._publish_moment()

    def update(self) -> None:
        """Tell how things stand."""
        changed = self._storeys.follow(self._localizer.snapshot)
        if changed is not None:
            self._out.forget_path()
            self._show(changed)
        frame, A_plan_odom = self.frame, self._localizer.output.A_plan_odom
        if frame is not None and A_plan_odom is not None:
            self._show(frame.followed(A_plan_odom))
        look = self._look(self._localizer.snapshot)
        moment = self._publish_moment()  # the tick may have found the robot after its newest scan
        if look.of is moment.snapshot and not self._health.is_starved:
            moment = replace(moment, look=look.at)
        report = self._storeys.noted(
            self._health.report(moment.output, self._settings().stale_input_s)
        )
        if moment.look is not None:
            report = replace(report, look=moment.look.words)
        self.told = report
        self._statuses.tell(report)
        self._out.publish_status(report)
        self._out.publish_tick(moment)

    def differences(self) -> None:
        """Tell where the drawing is out of date."""
        self._storeys.publish_differences(self._localizer.snapshot, self.frame)

    def floorplan(self, plan: ServedPlan, policy: ScalePolicy) -> None:
        """Give a floorplan to the localizer; where that refuses it the old one stays."""
        try:
            plan.give_to(self._localizer, policy)
        except FpnetError as error:
            self._node.get_logger().error(one_line(error))
            return
        self._out.forget_path()
        said = f'took the floorplan in frame {plan.frame_id}{plan.said_of_scale}'
        self._node.get_logger().info(said)
        self._show(MapFrame(plan.grid, plan.frame_id, self._settings().map_frame))
        self.update()

    def transform(self) -> None:
        """Repeat the TF for now and a little longer, as long as scans come; tell of a change."""
        settings, now_ns = self._settings(), self._now_ns()
        if self._node.is_active and self._health.has_turned(now_ns, settings.scan_timeout_s):
            self.update()
        if settings.sends_tf and now_ns and not self._health.is_starved:
            self._out.broadcast(now_ns + round(settings.transform_tolerance * NS_PER_S))

    def diagnostics(self, findings: Sequence[Finding]) -> None:
        """Tell how the node fares, and what is wrong around it."""
        news = self._health.news(self._localizer.output, self._settings().stale_input_s)
        self._out.publish_diagnostics(self._storeys.noted(news), findings, self._now_ns())

    def stop(self) -> None:
        """Claim nothing any more."""
        with self._lock:
            self._out.forget_pose()

    def _look(self, snapshot: Snapshot) -> _Looked:
        """Return where to look next; what was found for the same output stands."""
        looked, scan = self._looked, self.newest
        if looked is None or looked.of is not snapshot:
            at = None
            if snapshot.plan is not None and scan is not None:
                drawn = snapshot.plan.nominal.evidence
                at = next_look(drawn, snapshot.output, scan.T_odom_base)
            self._looked = looked = _Looked(snapshot, at)
        return looked

    def _publish_moment(self) -> StampedOutput:
        """Publish where the robot is, by what holds now, and return that."""
        with self._lock:  # of two threads the later one publishes the later moment
            moment = StampedOutput.of(self._localizer.snapshot, self.frame, self.newest)
            if self._node.is_active:
                self._out.publish_pose(moment)
        return moment

    def _show(self, frame: MapFrame) -> None:
        """Take the frame ``map`` as it is now; publish the floorplan in it if it has changed."""
        if frame is not self.frame:
            self.frame = frame
            self._out.publish_scaled(frame, self._now_ns())

    def _now_ns(self) -> int:
        return self._node.get_clock().now().nanoseconds
