# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Floorplans from messages, with their scales, and those of a site's floors; outdated drawings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import OccupancyGrid
import numpy as np
from std_msgs.msg import Float64, String

from fpnet_core.config import FpnetConfig, ScalePolicy
from fpnet_core.differences.outdated import DrawingWatch
from fpnet_core.errors import FpnetError, MapFormatError
from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_core.localizer import Localizer
from fpnet_core.localizer.localizer import Snapshot
from fpnet_core.localizer.map_frame import MapFrame
from fpnet_core.localizer.state import plan_fingerprint
from fpnet_core.raster.windows import known_window
from fpnet_core.segmentation import ScaleEstimate
from fpnet_core.sites.site_files import read_site
from fpnet_core.sites.site_localizer import SiteLocalizer
from fpnet_core.types import UNKNOWN, GridMap, Status
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.logs import one_line
from fpnet_ros.runtime import LATCHED, STREAM
from fpnet_ros.settings import LocalizerParameters
from msg_adapters.diagnostics import LocalizerReport
from msg_adapters.grids import confidence_to_msg, grid_from_msg
from msg_adapters.scales import GridScale, scale_from_msg
from msg_adapters.stamps import stamp_from_msg

SCALE_TOPIC = 'floorplan_scale'
"""Given: topic with the scale of ``floorplan``."""


class ServedPlan(NamedTuple):
    """A floorplan, its frame and the interval of its scale."""

    grid: GridMap
    frame_id: str
    scale: GridScale

    @property
    def said_of_scale(self) -> str:
        """A suffix for log lines about the floorplan; empty if its scale is stated."""
        return '' if self.scale.is_stated else f'; {self.scale.said}'

    def give_to(self, localizer: Localizer, policy: ScalePolicy) -> None:
        """
        Set the floorplan; its scale is searched unless it is stated or the policy is ``trusted``.

        Raises
        ------
        MapFormatError
            If it contains no room; the previous floorplan stays.
        """
        if self.scale.is_stated or policy == 'trusted':
            localizer.set_plan(self.grid)
            return
        estimate = ScaleEstimate(1.0, self.scale.low, self.scale.high)
        localizer.set_plan(self.grid, estimate, 'unknown')


class FloorplanInput:
    """
    Pairs the grids on ``floorplan`` with the scales on ``floorplan_scale``, by their stamps.

    The scale may arrive before or after its grid; without one the grid's resolution counts as
    stated. An unchanged grid, which some servers publish every few seconds, is ignored: it would
    restart the localizer. ``take`` gets each new floorplan, and again when its scale arrives late
    or changes, ``report`` the errors of unusable messages.
    """

    def __init__(
        self,
        node: ManagedNode,
        take: Callable[[ServedPlan], None],
        report: Callable[[FpnetError], None],
    ) -> None:
        self._take, self._report = take, report
        self._taken: ServedPlan | None = None
        self._fingerprint = ''  # of the floorplan in ``_taken``
        self._scale = GridScale(0)
        node.add_subscription(DiagnosticArray, SCALE_TOPIC, self._on_scale, LATCHED)
        node.add_subscription(OccupancyGrid, 'floorplan', self._on_grid, LATCHED)

    def _on_grid(self, msg: OccupancyGrid) -> None:
        frame_id, taken = plain_frame(msg.header.frame_id), self._taken
        try:
            if not frame_id:
                raise MapFormatError('its header has no frame_id; map_server uses map')
            grid = grid_from_msg(msg)
            grid = grid.cropped(*known_window(grid.cells != UNKNOWN))
        except FpnetError as error:
            kept = '; the previous floorplan stays' if taken is not None else ''
            self._report(MapFormatError(f'the floorplan was refused: {error}{kept}'))
            return
        stamp_ns, before = stamp_from_msg(msg.header.stamp), self._fingerprint
        self._fingerprint = plan_fingerprint(grid)
        if taken is not None and self._fingerprint == before and taken.frame_id == frame_id:
            # Its scale is unchanged too, unless a message with the new stamp changes it.
            self._taken = taken._replace(scale=replace(taken.scale, stamp_ns=stamp_ns))
            self._follow_scale()
            return
        scale = self._scale if self._scale.stamp_ns == stamp_ns else GridScale(stamp_ns)
        self._pass_on(ServedPlan(grid, frame_id, scale))

    def _on_scale(self, msg: DiagnosticArray) -> None:
        try:
            self._scale = scale_from_msg(msg)
        except FpnetError as error:
            self._report(error)
            return
        self._follow_scale()

    def _follow_scale(self) -> None:
        """Pass the floorplan on again if its scale has changed."""
        taken, scale = self._taken, self._scale
        if taken and taken.scale.stamp_ns == scale.stamp_ns and taken.scale != scale:
            self._pass_on(taken._replace(scale=scale))

    def _pass_on(self, plan: ServedPlan) -> None:
        self._taken = plan
        self._take(plan)


class StoreyTopics:
    """
    Topics ``~/storey``, its hints and ``~/differences`` of one configured localizer node.

    Without the parameter ``site`` floorplans are received as messages, and only ``~/differences``
    is offered. Raises FpnetError if the site cannot be read.
    """

    def __init__(
        self,
        node: ManagedNode,
        localizer: SiteLocalizer,
        config: FpnetConfig,
        parameters: LocalizerParameters,
    ) -> None:
        self._log, self._localizer = node.get_logger(), localizer
        self._map_frame = parameters.map_frame
        self._storey: str | None = None
        self._drawing = DrawingWatch()
        self._differences = node.add_publisher(OccupancyGrid, '~/differences', LATCHED)
        if parameters.site:
            localizer.set_site(read_site(Path(parameters.site), config))
            self._storey_topic = node.add_publisher(String, '~/storey', LATCHED)
            give = partial(self._take, 'storey_hint', localizer.tell_level, 'this is storey {}')
            node.add_subscription(String, '~/storey_hint', give, STREAM)
            give = partial(
                self._take, 'elevation_hint', localizer.tell_elevation, 'the floor is at {:g} m'
            )
            node.add_subscription(Float64, '~/elevation_hint', give, STREAM)

    def frame_named(self, frame_id: str) -> tuple[str, MapFrame] | None:
        """Return storey and frames for the frame of a storey's plan; None for other frames."""
        site = self._localizer.site
        for storey in () if site is None else site.storeys:
            if frame_id == _frame_of(storey.name):
                return storey.name, MapFrame(storey.plan.grid, frame_id, self._map_frame)
        return None

    def follow(self, snapshot: Snapshot) -> MapFrame | None:
        """Publish a newly accepted storey and return its frames; None if it is unchanged."""
        output, plan = snapshot.output, snapshot.plan
        is_accepted = output.A_plan_odom is not None and plan is not None
        if self._localizer.site is None or not is_accepted or output.storey == self._storey:
            return None
        assert plan is not None  # an accepted pose is on one
        self._storey = output.storey
        self._storey_topic.publish(String(data=output.storey))
        self._log.info(f'the robot is on storey {output.storey}')
        return MapFrame(plan.given, _frame_of(output.storey), self._map_frame)

    def publish_differences(self, snapshot: Snapshot, frame: MapFrame | None) -> None:
        """Publish differences from time to time; log when the drawing becomes outdated."""
        before = self._drawing.outdated
        output = snapshot.output
        found = self._drawing.follow(output, None if frame is None else snapshot.plan)
        after = self._drawing.outdated
        if after is not None and before is None:
            self._log.warning(after.said)
        elif before is not None and after is None and output.A_plan_odom is not None:
            self._log.info('the drawing agrees with the scans here')
        if found is None or frame is None or found.grid is not frame.plan:
            return
        percent = np.where(found.is_seen, np.rint(100.0 * found.confidence), -1.0)
        values = percent.astype(np.int8)
        self._differences.publish(
            confidence_to_msg(found.grid, values, output.stamp_ns, frame.plan_id)
        )

    def noted(self, report: LocalizerReport) -> LocalizerReport:
        """Return the report, with a note if the drawing is out of date around the pose."""
        outdated = self._drawing.outdated
        if outdated is None or report.status is not Status.LOCALIZED:
            return report
        values = {**report.values, 'outdated_share': outdated.share}
        return replace(report, outdated=outdated.said, values=values)

    def _take(
        self, topic: str, tell: Callable[[Any], None], said: str, msg: String | Float64
    ) -> None:
        """Pass a hint on and log it; ``said`` is what it says, with a place for its content."""
        try:
            tell(msg.data)
        except FpnetError as error:
            self._log.warning(f'{topic} was rejected: {one_line(error)}')
            return
        self._log.info(f'received the hint that {said.format(msg.data)}')


def _frame_of(storey: str) -> str:
    """Return the frame of a storey's plan: its name with ``/`` and spaces replaced."""
    return storey.replace('/', '_').replace(' ', '_')
