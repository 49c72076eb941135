# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Floorplans received as messages, paired with the interval of their scale."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import OccupancyGrid

from fpnet_core.config import ScalePolicy
from fpnet_core.errors import FpnetError, MapFormatError
from fpnet_core.geometry.frame_tree import plain_frame
from fpnet_core.localizer import Localizer
from fpnet_core.localizer.state import plan_fingerprint
from fpnet_core.raster.windows import known_window
from fpnet_core.segmentation import ScaleEstimate
from fpnet_core.types import UNKNOWN, GridMap
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.runtime import LATCHED
from msg_adapters.grids import grid_from_msg
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
        """Return a suffix for log lines about the floorplan; empty if its scale is stated."""
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
    restart the localizer.

    Parameters
    ----------
    take
        Called with each new floorplan, and again when its scale arrives late or changes.
    report
        Called with the error of an unusable message.
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
