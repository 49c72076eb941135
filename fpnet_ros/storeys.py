# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Topics of the localizer node for storeys, and for outdated drawings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from nav_msgs.msg import OccupancyGrid
import numpy as np
from std_msgs.msg import Float64, String

from fpnet_core.config import FpnetConfig
from fpnet_core.differences.outdated import DrawingWatch
from fpnet_core.errors import FpnetError
from fpnet_core.localizer.localizer import Snapshot
from fpnet_core.localizer.map_frame import MapFrame
from fpnet_core.sites.site_files import read_site
from fpnet_core.sites.site_localizer import SiteLocalizer
from fpnet_core.types import Status
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.logs import one_line
from fpnet_ros.runtime import LATCHED, STREAM
from msg_adapters.diagnostics import LocalizerReport
from msg_adapters.grids import confidence_to_msg


class StoreyTopics:
    """
    Topics ``~/storey``, its hints and ``~/differences`` of one configured localizer node.

    Parameters
    ----------
    node : owner of the topics
    localizer : receives the site and the hints
    site : path of its description; empty: floorplans are received as messages, and only
        ``~/differences`` is offered
    config, map_frame : parameters of the node

    Raises
    ------
    FpnetError
        If the site cannot be read.
    """

    def __init__(
        self,
        node: ManagedNode,
        localizer: SiteLocalizer,
        site: str,
        config: FpnetConfig,
        map_frame: str,
    ) -> None:
        self._log, self._localizer, self._map_frame = node.get_logger(), localizer, map_frame
        self._storey: str | None = None
        self._drawing = DrawingWatch()
        self._differences = node.add_publisher(OccupancyGrid, '~/differences', LATCHED)
        if site:
            localizer.set_site(read_site(Path(site), config))
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
