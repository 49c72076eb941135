# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet match`` on two drawings of one building, of other scale, turn and place."""

from dataclasses import replace
import json
import re

import cv2
import numpy as np
from planted import A_BUILDING_PLAN, building_cells, draw_building
import pytest

from fpnet.cli import main
from fpnet.cli.exits import NO_ANSWER
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.io.maps import read_map, write_map
from fpnet_core.types import FREE, OCCUPIED

PIXELS_PER_M = 14.0  # of the robot map below: nothing says so to the matcher
TURN_RAD = np.deg2rad(128.0)


def grey(cells):
    """Image rows, top first: free white, walls black, unknown mid grey."""
    image = np.full(cells.shape, 205, dtype=np.uint8)
    image[cells == FREE] = 254
    image[cells == OCCUPIED] = 0
    return image[::-1]


def write_plan(path):
    """The drawing at 0.05 m per pixel; returns the map from building metres to its pixels."""
    origin = SE2.from_xy_yaw(-10.0, -16.0, 0.3)
    grid = draw_building(A_BUILDING_PLAN, 0.05, 'plan', origin, (700, 800))
    image = grey(grid.cells)
    image[image == 205] = 0  # drawings are black outside
    cv2.imwrite(str(path), image)
    flip = Affine2D(np.diag([20.0, -20.0]), np.array([-0.5, 700 - 0.5]))
    return flip @ origin.inv() @ A_BUILDING_PLAN.inv()


def write_robot_map(path, keep):
    """A part of the building at another scale; returns building metres to its pixels."""
    rows, cols = 420, 460
    c, s = np.cos(TURN_RAD), np.sin(TURN_RAD)
    middle = np.array([10.0, 6.5])
    linear = PIXELS_PER_M * np.diag([1.0, -1.0]) @ np.array([[c, -s], [s, c]])
    to_pixels = Affine2D(linear, np.array([cols / 2, rows / 2]) - linear @ middle)
    v, u = np.mgrid[:rows, :cols]
    xy = to_pixels.inv().apply(np.stack([u, v], axis=-1))
    cells = building_cells(xy)
    cells[~keep(xy[..., 0], xy[..., 1])] = -1
    cv2.imwrite(str(path), grey(cells)[::-1])
    return to_pixels


def run_match(tmp_path, *extra, plan='plan.png', robot='robot.png'):
    out = tmp_path / 'match.json'
    arguments = ['match', '--floorplan', str(tmp_path / plan)]
    arguments += ['--submap', str(tmp_path / robot), '--json', str(out), *extra]
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    found = json.loads(out.read_text())
    assert ended.value.code == (0 if found['status'] == 'matched' else NO_ANSWER)
    return found


def test_a_partial_map_of_unknown_scale_is_placed_in_pixels(tmp_path, capsys):
    plan_px = write_plan(tmp_path / 'plan.png')
    robot_px = write_robot_map(tmp_path / 'robot.png', lambda x, y: (x < 15) | (y > 5.2))
    result = run_match(tmp_path, '--plot', str(tmp_path / 'match.png'))
    assert result['status'] == 'matched'
    got = Affine2D.from_matrix(result['affine_plan_from_submap_px'])
    corners = robot_px.apply([[0.0, 0.0], [20.0, 0.0], [0.0, 13.0], [14.0, 13.0]])
    truth = plan_px @ robot_px.inv()
    assert np.linalg.norm(got.apply(corners) - truth.apply(corners), axis=1).max() < 8.0
    assert set(result) >= {'status', 'affine_plan_from_submap_px', 'score', 'timings_ms'}
    share, walls_m = re.match(
        r'explains (\d+) % of (\d+) m of observed wall', result['reason']
    ).groups()
    assert int(share) > 60
    assert int(walls_m) > 50
    assert re.search(r'; (no runner-up|runner-up .*: \d+ %)', result['reason'])
    said = f'matched (p {result["probability"]:.2f}): {result["reason"]}\n'
    scale, *_, printed = capsys.readouterr().out.splitlines(keepends=True)
    assert printed == said
    assert scale.startswith('plan.png: ')
    assert re.search(r' m per pixel \([\d.]+ to [\d.]+\), estimated from ', scale)
    assert cv2.imread(str(tmp_path / 'match.png')) is not None

    assert not result['plan_scale_stated']
    assert not result['submap_scale_stated']
    # The robot's counts 0.05 m per pixel, the plan's what its rooms and doors say.
    in_pixels = result['scale'] * 0.05 / result['plan_metres_per_pixel']
    assert in_pixels == pytest.approx(20.0 / PIXELS_PER_M, rel=0.03)


def write_stated(tmp_path, plan_resolution_m=0.05):
    """Both maps as map_server has them; the plan's true resolution is 0.05 m."""
    write_plan(tmp_path / 'plan.png')
    write_robot_map(tmp_path / 'robot.png', lambda x, y: (x < 15) | (y > 5.2))
    write_map(read_map(tmp_path / 'plan.png', plan_resolution_m), tmp_path / 'stated.yaml')
    robot = replace(read_map(tmp_path / 'robot.png'), resolution=1.0 / PIXELS_PER_M)
    write_map(robot, tmp_path / 'metric.yaml')


def test_a_stated_scale_is_trusted_within_its_tolerance(tmp_path):
    write_stated(tmp_path)
    result = run_match(tmp_path, plan='stated.yaml', robot='metric.yaml')
    assert result['status'] == 'matched'
    assert result['scale'] == pytest.approx(1.0, abs=0.02)
    assert result['plan_scale_stated']
    assert result['submap_scale_stated']


@pytest.mark.parametrize(
    ('policy', 'factor'),
    [('trusted', 1.2), ('approximate', 1.2), ('approximate', 1.6), ('unknown', 1.3)],
)
def test_a_plan_of_wrong_scale_is_found_as_far_as_its_scale_may_be_doubted(
    tmp_path, policy, factor
):
    write_stated(tmp_path, 0.05 * factor)
    trust = f'--set=localizer.scale_policy={policy}'
    result = run_match(tmp_path, trust, plan='stated.yaml', robot='metric.yaml')
    is_found = result['status'] == 'matched'
    reach = {'trusted': 1.0, 'approximate': 1.35, 'unknown': 2.0}
    assert is_found == (factor < reach[policy])
    assert (result['scale'] == pytest.approx(factor, rel=0.03)) == is_found
    assert is_found or abs(np.log(result['scale'])) < np.log(reach[policy]) + 0.1


def test_a_metric_robot_map_gives_a_bare_plan_its_scale(tmp_path):
    write_stated(tmp_path)
    plan_image = cv2.imread(str(tmp_path / 'plan.png'), cv2.IMREAD_GRAYSCALE)
    larger = cv2.resize(plan_image, None, fx=1.6, fy=1.6, interpolation=cv2.INTER_NEAREST)
    cv2.imwrite(str(tmp_path / 'larger.png'), larger)
    result = run_match(tmp_path, plan='larger.png', robot='metric.yaml')
    assert result['status'] == 'matched'
    assert not result['plan_scale_stated']
    assert result['submap_scale_stated']
    metres_per_pixel = result['plan_metres_per_pixel'] / result['scale']
    assert metres_per_pixel == pytest.approx(0.05 / 1.6, rel=0.03)


def test_a_cloud_states_its_scale(tmp_path):
    write_stated(tmp_path)
    grid = read_map(tmp_path / 'metric.yaml')
    floor = grid.rc_to_xy(np.argwhere(grid.cells == FREE))
    wall = grid.rc_to_xy(np.argwhere(grid.cells == OCCUPIED))
    layers = [np.column_stack([wall, np.full(len(wall), z)]) for z in np.arange(0.1, 2.6, 0.3)]
    ground = np.column_stack([floor, np.zeros(len(floor))])
    np.save(tmp_path / 'cloud.npy', np.concatenate([ground, *layers]))
    result = run_match(tmp_path, plan='stated.yaml', robot='cloud.npy')
    assert (result['plan_scale_stated'], result['submap_scale_stated']) == (True, True)
    assert result['status'] == 'matched'
    assert result['scale'] == pytest.approx(1.0, abs=0.02)


def test_one_plain_room_is_not_claimed(tmp_path):
    write_plan(tmp_path / 'plan.png')
    write_robot_map(tmp_path / 'robot.png', lambda x, y: (x > 0.3) & (x < 6.5) & (y < 4.5))
    result = run_match(tmp_path)
    assert result['status'] != 'matched'
    assert result['reason']


def test_a_map_without_free_space_is_one_clear_error(tmp_path, capsys):
    write_plan(tmp_path / 'plan.png')
    cv2.imwrite(str(tmp_path / 'robot.png'), np.zeros((50, 60), dtype=np.uint8))
    arguments = ['match', '--floorplan', str(tmp_path / 'plan.png')]
    with pytest.raises(SystemExit) as ended:
        main([*arguments, '--submap', str(tmp_path / 'robot.png')])
    assert ended.value.code == 1
    error = capsys.readouterr().err
    assert error.startswith('fpnet: ')
    assert error.count('\n') == 1
