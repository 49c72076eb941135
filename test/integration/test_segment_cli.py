# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet segment`` on every kind of input that it takes, and on those that it cannot."""

import json

import numpy as np
import open3d as o3d
from PIL import Image
from planted import CORRIDOR, DOORS, ROOMS, building_cells
from planted_drive import SCAN_NS, recorded
import pytest

from fpnet.bag_writer import BagWriter
from fpnet.cli import main
from fpnet_core.geometry import SE2
from fpnet_core.io.maps import write_map
from fpnet_core.types import FREE, OCCUPIED, GridMap

RESOLUTION_M = 0.05
CORNER = (-1.0, -1.0)
SHAPE = (300, 440)
WALL_M = 0.2


def building():
    """The planted building, level, in its own metres."""
    origin = SE2.from_xy_yaw(*CORNER, 0.0)
    blank = GridMap(np.zeros(SHAPE, np.int8), RESOLUTION_M, origin)
    rc = np.stack(np.meshgrid(*map(np.arange, SHAPE), indexing='ij'), axis=-1)
    return GridMap(building_cells(blank.rc_to_xy(rc)), RESOLUTION_M, origin)


def cloud():
    """Points on the building's floor and walls, and on the lintels of its doors."""
    grid = building()
    floor = grid.rc_to_xy(np.argwhere(grid.cells == FREE)[::2])
    wall = grid.rc_to_xy(np.argwhere(grid.cells == OCCUPIED))
    heights = np.arange(0.1, 2.6, 0.3)
    layers = [np.column_stack([wall, np.full(len(wall), z)]) for z in heights]
    return np.concatenate([np.column_stack([floor, np.zeros(len(floor))]), *layers])


def write_image(path):
    pixels = np.where(building().cells == FREE, 255, 0).astype(np.uint8)[::-1]
    Image.fromarray(pixels).save(path)


def write_yaml(path):
    write_map(building(), path)


def write_npy(path):
    np.save(path, cloud())


def write_points(path):
    o3d.io.write_point_cloud(
        str(path), o3d.geometry.PointCloud(o3d.utility.Vector3dVector(cloud()))
    )


def write_bag(path, storage):
    with BagWriter(path, storage) as bag:
        for points, T_odom_sensor, stamp_ns in recorded():
            bag.write_odometry('/odom', stamp_ns, 'odom', 'lidar', T_odom_sensor)
            bag.write_cloud('/points', stamp_ns, 'lidar', points)
    assert stamp_ns == len(recorded()) * SCAN_NS


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main(['segment', *map(str, arguments)])
    return ended.value.code or 0


def segment(source, *options):
    target = source.parent / 'rooms.json'
    assert run(source, '--json', target, *options) == 0
    return json.loads(target.read_text())


def assert_is_the_building(result):
    areas = sorted(
        (x1 - x0 - WALL_M) * (y1 - y0 - WALL_M) for x0, y0, x1, y1 in (*ROOMS, CORRIDOR)
    )
    assert sorted(room['area_m2'] for room in result['rooms']) == pytest.approx(areas, rel=0.08)
    middles = np.array([np.mean(door['ends_xy_m'], axis=0) for door in result['doors']])
    assert len(middles) == len(DOORS)
    for door in DOORS:
        assert np.hypot(*(middles - door).T).min() < 0.25


@pytest.mark.parametrize('suffix', ['png', 'jpg', 'pgm'])
def test_an_image_of_known_resolution(tmp_path, suffix):
    write_image(tmp_path / f'plan.{suffix}')
    result = segment(tmp_path / f'plan.{suffix}', '--resolution', RESOLUTION_M)
    for door in result['doors']:
        door['ends_xy_m'] = (np.array(door['ends_xy_m']) + CORNER).tolist()
    assert_is_the_building(result)


def test_an_image_without_a_scale_gets_one_from_its_rooms_and_doors(tmp_path):
    write_image(tmp_path / 'plan.png')
    result = segment(tmp_path / 'plan.png')
    assert len(result['rooms']) == len(ROOMS) + 1
    scale = result['drawing']['scale']
    assert scale['interval'][0] < RESOLUTION_M < scale['interval'][1]
    assert scale['metres_per_pixel'] == pytest.approx(RESOLUTION_M, rel=0.3)
    largest_m2 = max(room['area_m2'] for room in result['rooms'])
    true_m2 = 8.8 * 5.8 * (scale['metres_per_pixel'] / RESOLUTION_M) ** 2
    assert largest_m2 == pytest.approx(true_m2, rel=0.08)


def test_a_robot_map_without_a_scale_has_a_factor(tmp_path):
    write_image(tmp_path / 'map.png')
    result = segment(tmp_path / 'map.png', '--submap')
    assert result['drawing'] is None
    assert result['resolution_m'] == RESOLUTION_M
    assert result['scale']['low'] < 1.0 < result['scale']['high']


def test_places_of_a_drawing_are_its_own_pixels(tmp_path):
    write_image(tmp_path / 'plan.png')
    result = segment(tmp_path / 'plan.png', '--length', '0,100,100,100=5')
    affine = np.array(result['affine_xy_from_px'])
    assert affine[:, :2] @ (100.0, 0.0) == pytest.approx((5.0, 0.0), abs=1e-6)
    assert affine[:, :2] @ (0.0, 100.0) == pytest.approx((0.0, -5.0), abs=1e-6)


def test_a_map_server_yaml_keeps_its_frame(tmp_path):
    write_yaml(tmp_path / 'plan.yaml')
    plot = tmp_path / 'pictures' / 'rooms.png'
    result = segment(tmp_path / 'plan.yaml', '--plot', plot)
    assert_is_the_building(result)
    with Image.open(plot) as picture:
        drawn = np.asarray(picture.convert('RGB')).reshape(-1, 3)
    assert len(np.unique(drawn, axis=0)) > len(ROOMS)


@pytest.mark.parametrize(
    ('name', 'write'), [('a.npy', write_npy), ('a.ply', write_points), ('a.pcd', write_points)]
)
def test_a_cloud_of_floor_and_walls(tmp_path, name, write):
    write(tmp_path / name)
    assert_is_the_building(segment(tmp_path / name))


def test_a_storey_of_a_cloud(tmp_path, capsys):
    middle = cloud().mean(axis=0) * (1.0, 1.0, 0.0)
    below = 2.0 * middle - cloud() * (1.0, 1.0, -1.0) - (0.0, 0.0, 3.0)
    np.save(tmp_path / 'two.npy', np.concatenate([below, cloud()]))
    assert_is_the_building(segment(tmp_path / 'two.npy', '--storey', '2'))
    assert run(tmp_path / 'two.npy', '--storey', '3') == 1
    assert 'storey 3: the cloud shows 2' in capsys.readouterr().err


@pytest.mark.parametrize('storage', ['sqlite3', 'mcap'])
def test_a_bag_with_odometry(tmp_path, storage):
    write_bag(tmp_path / 'bag', storage)
    result = segment(tmp_path / 'bag')
    seen = [room for room in result['rooms'] if room['observed_fraction'] > 0.9]
    assert len(seen) >= 3
    assert len(result['doors']) >= len(DOORS) - 1


def test_the_result_goes_to_stdout_alone(tmp_path, capsys):
    write_yaml(tmp_path / 'plan.yaml')
    assert run(tmp_path / 'plan.yaml', '--json', '-') == 0
    assert len(json.loads(capsys.readouterr().out)['rooms']) == len(ROOMS) + 1


def broken(folder):
    """Files that cannot be segmented, with a word of the line that says so."""
    (folder / 'empty.png').write_bytes(b'')
    (folder / 'cut.png').write_bytes(b'\x89PNG\r\n\x1a\n' + bytes(30))
    Image.new('1', (20_000, 20_000)).save(folder / 'huge.png')
    (folder / 'no.yaml').write_text('image: [1')
    (folder / 'empty.ply').write_text('')
    np.save(folder / 'flat.npy', np.zeros((5, 2)))
    np.save(folder / 'one.npy', np.zeros((1, 3)))
    (folder / 'notes.txt').write_text('no map')
    (folder / 'bag').mkdir()
    return {
        'missing.png': 'does not exist', 'empty.png': 'empty.png is empty',
        'cut.png': 'not a readable image', 'huge.png': 'at most 100 million pixels',
        'no.yaml': 'no.yaml', 'empty.ply': 'empty.ply', 'flat.npy': 'flat.npy',
        'notes.txt': 'notes.txt', 'bag': 'bag',
    }  # fmt: skip


def test_what_cannot_be_segmented_ends_in_one_line(tmp_path, capsys):
    for name, word in broken(tmp_path).items():
        assert run(tmp_path / name) == 1, name
        shown = capsys.readouterr()
        assert shown.err.startswith('fpnet: '), name
        assert shown.err.count('\n') == 1, name
        assert word in shown.err, name
        assert not shown.out, name


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('--submap', '--length', '0,0,9,0=1'), '--length applies to drawings, but {} is read'),
        (('--submap', '--mirrored'), '--mirrored applies to drawings'),
        (('--resolution', '0.1', '--length', '0,0,9,0=1'), 'both state the scale'),
    ],
)
def test_options_that_say_nothing_of_the_input_are_refused(tmp_path, capsys, arguments, message):
    write_map(building(), tmp_path / 'map.yaml')
    with pytest.raises(SystemExit, match='1'):
        main(['segment', str(tmp_path / 'map.png'), *arguments])
    assert message.format(tmp_path / 'map.png') in capsys.readouterr().err


@pytest.mark.parametrize('name', ['white.png', 'black.png', 'pixel.png', 'one.npy'])
def test_nothing_to_segment_gives_a_reason_and_exits_1(tmp_path, capsys, name):
    Image.new('L', (60, 40), 255).save(tmp_path / 'white.png')
    Image.new('L', (60, 40), 0).save(tmp_path / 'black.png')
    Image.new('L', (1, 1), 255).save(tmp_path / 'pixel.png')
    np.save(tmp_path / 'one.npy', np.zeros((1, 3)))
    stated = () if name == 'one.npy' else ('--resolution', RESOLUTION_M)
    assert run(tmp_path / name, *stated) == 1
    shown = capsys.readouterr()
    assert len((shown.err + shown.out).strip().splitlines()) <= 2
    assert len(shown.err + shown.out) > 20
