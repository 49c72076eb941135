# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Node that publishes a floorplan file as a latched OccupancyGrid, like map_server."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import OccupancyGrid
from pydantic import Field
from std_srvs.srv import Trigger

from fpnet_core.config import Section
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import Reading, ReadOptions
from fpnet_core.drawings.wording import said_of_scale
from fpnet_core.errors import ConfigError, FpnetError
from fpnet_ros.floorplans import SCALE_TOPIC
from fpnet_ros.lifecycle import ManagedNode, run_managed
from fpnet_ros.params import ParameterTree
from fpnet_ros.runtime import LATCHED, one_line
from msg_adapters.grids import grid_to_msg
from msg_adapters.scales import GridScale, scale_to_msg


class FloorplanServerParameters(Section):
    """Parameters of the floorplan server: the file to publish and its frame."""

    floorplan: str = Field(
        '', description='Map YAML of map_server, or a drawing: image, PDF, SVG, DXF.'
    )
    resolution_m: float = Field(
        0.0, ge=0.0, description='Metres per pixel of a drawing; 0: as stated, or estimated.'
    )
    storey: int = Field(0, ge=0, description='Floor on the sheet, from 1; 0: the largest.')
    page: int = Field(0, ge=0, description='Page of a PDF, from 1; 0: the likeliest one.')
    frame_id: str = Field('floorplan', description='Frame of the published grid.')


class FloorplanServer(ManagedNode):
    """
    Publishes ``floorplan`` once, latched.

    ``~/reload`` reads the file again, with the current parameters.
    """

    def __init__(self) -> None:
        super().__init__('floorplan_server')
        self._settings = ParameterTree(
            self,
            FloorplanServerParameters,
            live=('floorplan', 'resolution_m', 'storey', 'page', 'frame_id'),
        )

    def configure(self) -> None:
        """Read the floorplan; raise FpnetError if it is missing or unreadable."""
        self._reading = self._read()
        self._scale_publisher = self.add_publisher(DiagnosticArray, SCALE_TOPIC, LATCHED)
        self._publisher = self.add_publisher(OccupancyGrid, 'floorplan', LATCHED)
        self.add_service(Trigger, '~/reload', self._on_reload)

    def activate(self) -> None:
        """Publish the floorplan."""
        self._publish()

    def _read(self) -> Reading:
        parameters = self._settings.value
        if not parameters.floorplan:
            raise ConfigError('parameter floorplan is empty; set it to a map YAML or a drawing')
        options = ReadOptions(
            resolution_m=parameters.resolution_m or None,
            storey=parameters.storey or None,
            page=parameters.page or None,
        )
        reading = read_plan(Path(parameters.floorplan), options)
        if reading.accepted:
            self.get_logger().info(f'{reading.drawing.name} is accepted: {reading.accepted}')
        for doubt in () if reading.accepted else reading.doubts:
            self.get_logger().warning(f'parser warning for {reading.drawing.name}: {doubt}')
        if not reading.scale.is_known:
            self.get_logger().warning(
                f'{said_of_scale(reading.scale)}; the localizer will search the scale; '
                'set resolution_m if you know it'
            )
        return reading

    def _publish(self) -> None:
        parameters = self._settings.value
        stamp_ns = self.get_clock().now().nanoseconds
        grid, estimate = self._reading.grid, self._reading.estimate
        said = said_of_scale(self._reading.scale)
        scale = GridScale(stamp_ns, said=said)
        if estimate is not None:
            scale = GridScale(stamp_ns, estimate.low, estimate.high, said)
        self._scale_publisher.publish(scale_to_msg(scale))
        self._publisher.publish(grid_to_msg(grid, stamp_ns, parameters.frame_id))
        height, width = grid.shape
        self.get_logger().info(
            f'serving {parameters.floorplan}: {width} x {height} cells of {grid.resolution:g} m'
        )

    def _on_reload(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            self._reading = self._read()
        except FpnetError as error:
            response.message = one_line(error)
            self.get_logger().error(f'{response.message}; the previous floorplan stays')
            return response
        self._publish()
        response.success, response.message = True, f'read {self._settings.value.floorplan}'
        return response


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node and return the exit status."""
    return run_managed(FloorplanServer, arguments)
