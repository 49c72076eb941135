# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Publish a floorplan file as a latched OccupancyGrid, as map_server does."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
import sys

from nav_msgs.msg import OccupancyGrid
from pydantic import Field
from rclpy.node import Node

from fpnet_core.config import Section
from fpnet_core.errors import ConfigError
from fpnet_core.io.maps import read_map
from fpnet_ros.params import declare_section
from fpnet_ros.runtime import LATCHED, run_node
from msg_adapters.grids import grid_to_msg


class FloorplanServerParameters(Section):
    """What to publish, and under which frame."""

    floorplan: str = Field('', description='Map YAML of map_server, or a PNG or PGM image.')
    resolution_m: float = Field(
        0.0, ge=0.0, description='Metres per pixel of an image; 0 reads it from the YAML.'
    )
    frame_id: str = Field('floorplan', description='Frame of the published grid.')


class FloorplanServer(Node):
    """Publishes ``floorplan`` once; late subscribers get it too."""

    def __init__(self) -> None:
        super().__init__('floorplan_server')
        parameters = declare_section(self, FloorplanServerParameters)
        if not parameters.floorplan:
            raise ConfigError('parameter floorplan is empty; set it to a map YAML or an image')
        grid = read_map(Path(parameters.floorplan), parameters.resolution_m or None)
        stamp_ns = self.get_clock().now().nanoseconds
        self._publisher = self.create_publisher(OccupancyGrid, 'floorplan', LATCHED)
        self._publisher.publish(grid_to_msg(grid, stamp_ns, parameters.frame_id))
        height, width = grid.shape
        self.get_logger().info(
            f'serving {parameters.floorplan}: {width} x {height} cells of {grid.resolution:g} m'
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node; returns the exit status."""
    return run_node(FloorplanServer, arguments)


if __name__ == '__main__':
    sys.exit(main())
