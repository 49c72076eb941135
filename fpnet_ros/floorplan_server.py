# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Node that publishes a floorplan file as a latched OccupancyGrid, like map_server."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import OccupancyGrid
from std_srvs.srv import Trigger

from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import Reading, ReadOptions
from fpnet_core.drawings.wording import said_of_scale
from fpnet_core.errors import ConfigError, FpnetError
from fpnet_ros.floorplans import SCALE_TOPIC
from fpnet_ros.lifecycle import ManagedNode, run_managed
from fpnet_ros.logs import one_line
from fpnet_ros.params import ParameterTree
from fpnet_ros.runtime import LATCHED
from fpnet_ros.settings import FloorplanServerParameters
from msg_adapters.grids import grid_to_msg
from msg_adapters.scales import GridScale, scale_to_msg


class FloorplanServer(ManagedNode):
    """
    Publishes ``floorplan`` once, latched.

    ``~/reload`` reads the file again, with the current parameters.
    """

    def __init__(self) -> None:
        super().__init__('floorplan_server')
        live = tuple(FloorplanServerParameters.model_fields)
        self._settings = ParameterTree(self, FloorplanServerParameters, live=live)

    def configure(self) -> None:
        """Read the floorplan; raise FpnetError if it is missing or unreadable."""
        self._reading = self._read()
        self._scale_publisher = self.add_publisher(DiagnosticArray, SCALE_TOPIC, LATCHED)
        self._publisher = self.add_publisher(OccupancyGrid, 'floorplan', LATCHED)
        self.add_service(Trigger, '~/reload', self._on_reload)

    def activate(self) -> None:
        """Publish the floorplan and what is known of its scale."""
        parameters, reading = self._settings.value, self._reading
        stamp_ns = self.get_clock().now().nanoseconds
        scale = GridScale(stamp_ns, said=said_of_scale(reading.scale))
        if (estimate := reading.estimate) is not None:
            scale = GridScale(stamp_ns, estimate.low, estimate.high, scale.said)
        self._scale_publisher.publish(scale_to_msg(scale))
        self._publisher.publish(grid_to_msg(reading.grid, stamp_ns, parameters.frame_id))
        height, width = reading.grid.shape
        size = f'{width} x {height} cells of {reading.grid.resolution:g} m'
        self.get_logger().info(f'serving {parameters.floorplan}: {size}')

    def _read(self) -> Reading:
        parameters, logger = self._settings.value, self.get_logger()
        if not parameters.floorplan:
            raise ConfigError('parameter floorplan is empty; set it to a map YAML or a drawing')
        options = ReadOptions(
            resolution_m=parameters.resolution_m or None,
            length=_numbers('length', parameters.length, 5, 'X1, Y1, X2, Y2 and metres'),
            crop=_numbers('crop', parameters.crop, 4, 'left, top, right and bottom'),
            storey=parameters.storey or None,
            page=parameters.page or None,
            layers=tuple(filter(None, parameters.layers)),
        )
        reading = read_plan(Path(parameters.floorplan), options)
        if parameters.mirrored:
            reading = reading.flipped()
        if reading.accepted:
            logger.info(f'{reading.drawing.name} is accepted: {reading.accepted}')
        for doubt in () if reading.accepted else reading.doubts:
            logger.warning(f'parser warning for {reading.drawing.name}: {doubt}')
        if not reading.scale.is_known:
            logger.warning(
                f'{said_of_scale(reading.scale)}; the localizer will search the scale; '
                'set resolution_m if you know it'
            )
        return reading

    def _on_reload(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            self._reading = self._read()
        except FpnetError as error:
            response.message = one_line(error)
            self.get_logger().error(f'{response.message}; the previous floorplan stays')
            return response
        self.activate()
        response.success, response.message = True, f'read {self._settings.value.floorplan}'
        return response


def _numbers(name: str, given: tuple[Any, ...], count: int, expected: str) -> Any:
    """Return the numbers of a parameter, None if there are none."""
    if len(given) not in (0, count):
        raise ConfigError(f'parameter {name}: got {len(given)} numbers, expected {expected}')
    return given or None


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node and return the exit status."""
    return run_managed(FloorplanServer, arguments)
