# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The readers on real floorplans, robot maps, laser logs and lidar scans."""

from itertools import islice
import json

import numpy as np
from PIL import Image
import pytest
from real_data import DATA, needs
from scipy import ndimage

from fpnet.recordings.opening import open_scans
from fpnet_core.config import OdometryConfig, SubmapConfig
from fpnet_core.io.clouds import read_cloud
from fpnet_core.io.maps import read_map
from fpnet_core.io.scans import Scan
from fpnet_core.odometry import KissOdometry
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.submaps import SubmapBuilder
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN

pytestmark = [
    pytest.mark.real,
    needs('bormann', 'carpin', 'radish'),
]

PLANS = sorted(DATA.glob('bormann/floorplan/*.png'))
ROBOT_MAPS = sorted(DATA.glob('bormann/robot_maps/*.png')) + sorted(
    DATA.glob('carpin/robot_maps/*.png')
)


def white(path, level):
    return np.asarray(Image.open(path).convert('L')) >= level


@pytest.mark.parametrize('path', PLANS, ids=lambda path: path.stem)
def test_white_is_free_in_drawings_and_rooms_have_walls(path):
    cells = read_map(path).cells[::-1]
    free = cells == FREE
    # The data's labels count 250 and more as free; blurred edges may differ.
    assert (free != white(path, 250)).mean() < 0.03
    around = ndimage.binary_dilation(free) & ~free
    near_wall = ndimage.binary_dilation(cells == OCCUPIED, iterations=2)
    assert (near_wall & around).sum() > 0.9 * around.sum()
    assert (cells[[0, -1]] == UNKNOWN).mean() > 0.9


@pytest.mark.parametrize('path', ROBOT_MAPS, ids=lambda path: path.stem)
def test_white_is_free_in_robot_maps_and_the_rest_is_not(path):
    cells = read_map(path).cells[::-1]
    assert (white(path, 250) & (cells != FREE)).sum() < 0.001 * cells.size
    assert (~white(path, 235) & (cells == FREE)).sum() < 0.01 * cells.size
    assert (cells == UNKNOWN).mean() > 0.1


@pytest.mark.parametrize('name', ['basic', 'ed21', 'office', 'open'])
def test_outside_of_line_drawings_is_found(name):
    """The data set brings each drawing a second time, with the outside filled by hand."""
    drawn = read_map(DATA / f'priormaps/floorplan/{name}.png').cells
    filled = read_map(DATA / f'priormaps/floorplan/{name}_filled.png').cells
    assert ((drawn == FREE) != (filled == FREE)).mean() < 0.02


@pytest.mark.parametrize(
    ('folder', 'origin'),
    [('mesh_willowgarage', (-1.0, -5.0)), ('mesh_aws_hospital', (-14.0, -37.0))],
)
def test_map_server_files(folder, origin):
    grid = read_map(DATA / folder / 'floorplan_from_mesh.yaml')
    assert grid.resolution == 0.05
    np.testing.assert_allclose(grid.T_frame_grid.translation, origin)
    np.testing.assert_array_equal(
        grid.cells[::-1] == FREE, white(DATA / folder / 'floorplan_from_mesh.pgm', 250)
    )


def test_mesh_vertices_lie_on_the_walls_cut_from_the_mesh():
    """Cloud and map are read by different code: they agree if frames and flips are right."""
    grid = read_map(DATA / 'mesh_willowgarage/floorplan_from_mesh.yaml')
    points = read_cloud(DATA / 'mesh_willowgarage/willow_mesh.ply')
    A = pixel_to_xy(grid)
    pixels = np.rint(A.inv().apply(points[:, :2])).astype(int)
    inside = ((pixels >= 0) & (pixels < grid.shape[::-1])).all(axis=1)
    walls = ndimage.binary_dilation(grid.cells[::-1] == OCCUPIED, iterations=3)
    on_wall = walls[pixels[inside, 1], pixels[inside, 0]].mean()
    upside_down = walls[::-1][pixels[inside, 1], pixels[inside, 0]].mean()
    assert on_wall > 0.95
    assert on_wall > 2.0 * upside_down


@pytest.mark.parametrize('name', ['intel', 'freiburg-079', 'csail', 'orebro'])
def test_laser_logs_draw_the_published_raster(name):
    """Scan ends fall on occupied pixels of the map that was drawn from the same log."""
    meta = json.loads((DATA / 'radish/maps_index.json').read_text())[name]
    scans = open_scans(DATA / f'radish/logs/{name}-corrected.log.gz')
    assert (scans.kind, scans.has_poses, len(scans)) == ('carmen', True, meta['n_scans'])
    walls = np.asarray(Image.open(DATA / f'radish/maps/{name}.png').convert('L')) < 50
    walls = ndimage.binary_dilation(walls, iterations=2)
    hits, before = [], -1
    for scan in scans:
        assert scan.stamp_ns > before
        before = scan.stamp_ns
        near = scan.points[np.linalg.norm(scan.points, axis=1) < 10.0]
        world = near @ scan.T_odom_sensor[:3, :3].T + scan.T_odom_sensor[:3, 3]
        column = ((world[:, 0] - meta['world_min_xy'][0]) / 0.05).astype(int)
        row = ((meta['world_max_xy'][1] - world[:, 1]) / 0.05).astype(int)
        pixels = np.stack([row, column], axis=1)
        inside = ((pixels >= 0) & (pixels < walls.shape)).all(axis=1)
        hits.append(walls[row[inside], column[inside]].mean())
    assert np.mean(hits) > 0.9


def test_every_laser_log_is_read():
    paths = sorted(DATA.glob('radish/logs/*.log.gz'))
    assert len(paths) >= 10
    for path in paths:
        scans = open_scans(path)
        scan = next(iter(scans))
        assert len(scans) > 200
        assert len(scan.points) > 20


def test_hall_scans_line_up_and_make_a_submap():
    """Real 3D scans with their poses: consecutive ones overlap, and free space is carved."""
    source = open_scans(DATA / 'real_hilti_hall_balm')
    assert (source.kind, len(source), source.has_poses) == ('folder', 177, True)
    builder = SubmapBuilder(SubmapConfig())
    for scan in source:
        builder.add_scan(scan.points, scan.T_odom_sensor, scan.stamp_ns)
    submap = builder.take()
    assert submap.free_area_m2 > 500.0
    assert submap.stamp_ns == scan.stamp_ns
    assert np.ptp(submap.path_xy, axis=0).max() > 5.0


def test_kiss_icp_follows_the_hall_scans():
    """2 Hz and a quarter of the points: within 10 cm of the given poses after 30 scans."""
    odometry = KissOdometry(OdometryConfig(max_range=60.0, voxel_size=0.5))
    scans = list(islice(open_scans(DATA / 'real_hilti_hall_balm'), 30))
    for scan in scans:
        sweep = odometry.register_scan(Scan(scan.stamp_ns, scan.points))
    T_first_last = np.linalg.inv(scans[0].T_odom_sensor) @ scans[-1].T_odom_sensor
    np.testing.assert_allclose(sweep.T_odom_sensor[:3, 3], T_first_last[:3, 3], atol=0.1)
