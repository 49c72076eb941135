# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import math

from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nav_msgs.msg import OccupancyGrid
import numpy as np
from PIL import Image
from planted import plan_grid
import pytest
from std_srvs.srv import Trigger

from fpnet_core.drawings.read import read_plan
from fpnet_core.geometry import SE2
from fpnet_core.io.maps import read_map, write_map
from fpnet_core.types import FREE, GridMap
from fpnet_ros.runtime import LATCHED
from msg_adapters.grids import grid_from_msg
from msg_adapters.scales import scale_from_msg
from msg_adapters.stamps import stamp_from_msg

pytestmark = pytest.mark.ros


def _floorplan() -> GridMap:
    cells = np.full((40, 70), 100, dtype=np.int8)
    cells[5:30, 5:60] = 0
    cells[35:, 65:] = -1
    return GridMap(cells, 0.1, SE2.from_xy_yaw(-3.0, 7.5, math.radians(25.0)))


def test_a_late_joiner_gets_the_floorplan(bench, tmp_path):
    path = tmp_path / 'plan.yaml'
    write_map(_floorplan(), path)
    server = bench.start('floorplan_server', {'floorplan': str(path), 'frame_id': 'drawing'})
    assert bench.wait_for(lambda: 'serving' in server.log_tail()), server.log_tail()
    # Only now does anyone subscribe: the grid was published before.
    received = bench.collect(OccupancyGrid, 'floorplan', LATCHED)
    assert bench.wait_for(lambda: bool(received)), server.log_tail()
    assert received[0].header.frame_id == 'drawing'
    grid, stored = grid_from_msg(received[0]), read_map(path)
    np.testing.assert_array_equal(grid.cells, stored.cells)
    np.testing.assert_allclose(grid.T_frame_grid.matrix, stored.T_frame_grid.matrix, atol=1e-9)
    assert grid.resolution == 0.1
    scales = bench.collect(DiagnosticArray, 'floorplan_scale', LATCHED)
    assert bench.wait_for(lambda: bool(scales)), server.log_tail()
    assert scale_from_msg(scales[0]).is_stated
    assert scales[0].header.stamp == received[0].header.stamp


def test_it_reloads_the_file_and_keeps_the_old_floorplan_where_that_fails(bench, tmp_path):
    path = tmp_path / 'plan.yaml'
    write_map(_floorplan(), path)
    server = bench.start('floorplan_server', {'floorplan': str(path), 'autostart': False})
    received = bench.collect(OccupancyGrid, 'floorplan', LATCHED)

    def change(transition: int) -> bool:
        request = ChangeState.Request(transition=Transition(id=transition))
        return bench.call(ChangeState, 'floorplan_server/change_state', request).success

    plain = path.read_text()
    path.unlink()
    assert not change(Transition.TRANSITION_CONFIGURE)
    assert 'plan.yaml' in server.log_tail()
    path.write_text(plain)
    assert change(Transition.TRANSITION_CONFIGURE)
    assert received == []
    assert change(Transition.TRANSITION_ACTIVATE)
    assert bench.wait_for(lambda: len(received) == 1, 60.0), server.log_tail()
    write_map(GridMap(_floorplan().cells, 0.2), path)
    assert bench.call(Trigger, 'floorplan_server/reload').success
    assert bench.wait_for(lambda: len(received) == 2, 60.0), server.log_tail()
    assert grid_from_msg(received[-1]).resolution == 0.2
    path.write_text('image: absent.png')
    response = bench.call(Trigger, 'floorplan_server/reload')
    assert not response.success
    assert 'plan.yaml' in response.message
    assert server.process.poll() is None


def test_a_drawing_without_a_scale_is_read_as_every_command_does_and_warned_of(bench, tmp_path):
    path = tmp_path / 'sheet.png'
    pixels = np.where(plan_grid().cells == FREE, 255, 0).astype(np.uint8)[::-1]
    Image.fromarray(pixels).save(path)
    server = bench.start('floorplan_server', {'floorplan': str(path)})
    assert bench.wait_for(lambda: 'serving' in server.log_tail()), server.log_tail()
    received = bench.collect(OccupancyGrid, 'floorplan', LATCHED)
    assert bench.wait_for(lambda: bool(received)), server.log_tail()
    grid, read = grid_from_msg(received[0]), read_plan(path).grid
    np.testing.assert_array_equal(grid.cells, read.cells)
    assert grid.resolution == pytest.approx(read.resolution, rel=1e-6)
    assert 'will search the scale' in server.log_tail()
    scales = bench.collect(DiagnosticArray, 'floorplan_scale', LATCHED)
    assert bench.wait_for(lambda: bool(scales)), server.log_tail()
    scale, estimate = scale_from_msg(scales[0]), read_plan(path).estimate
    assert scale.stamp_ns == stamp_from_msg(received[0].header.stamp)
    assert (scale.low, scale.high) == pytest.approx((estimate.low, estimate.high))
    assert not scale.is_stated


def test_bad_parameters_end_the_node_with_one_line(bench):
    cases = {
        'empty': ({}, 'parameter floorplan is empty'),
        'missing': ({'floorplan': 'missing.yaml'}, 'missing.yaml'),
    }
    started = {
        name: bench.start_as(name, 'floorplan_server', parameters)
        for name, (parameters, _) in cases.items()
    }
    for name, (_, message) in cases.items():
        assert started[name].process.wait(timeout=180) == 1
        lines = started[name].log_tail().splitlines()
        assert len(lines) == 1
        assert message in lines[0]
