# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet align`` on a planted building: transform, corrected plan, exports, refusals."""

from dataclasses import replace
import json

import ezdxf
import numpy as np
from PIL import Image
from planted import (
    A_BUILDING_PLAN,
    A_PLAN_SUBMAP,
    ROOMS,
    building_cells,
    plan_grid,
    submap_grid,
)
from planted_site import GONE_WALL, OTHER_WALLS, building_xy, inside, other_storey
import pytest
import yaml

import fpnet
from fpnet.cli import main
from fpnet.cli.exits import NO_ANSWER
from fpnet.exports.segmented_model import complete_model
from fpnet.exports.writing import write_model
from fpnet_core.config import FpnetConfig
from fpnet_core.errors import NotPlacedError
from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import read_map, write_map
from fpnet_core.sites.open_rmf import read_open_rmf
from fpnet_core.types import FREE, OCCUPIED

CORNERS = np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 11.0], [0.0, 13.0], [10.0, 6.0]])
"""Places of the building [m], in its own frame."""

CORNERS_PLAN = A_BUILDING_PLAN.inv().apply(CORNERS)
CORNERS_MAP = A_PLAN_SUBMAP.inv().apply(CORNERS_PLAN)


def call(*words):
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    return ended.value.code or 0


def errors_m(A, xy_from, xy_to):
    return np.linalg.norm(A.apply(xy_from) - xy_to, axis=1).max()


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Hold the outputs for a drawing of the building, and for one with other walls."""
    folder = tmp_path_factory.mktemp('align')
    write_map(plan_grid(), folder / 'plan.yaml')
    write_map(other_storey(), folder / 'outdated.yaml')
    write_map(submap_grid(), folder / 'robot.yaml')
    for plan, out in (('plan', 'out'), ('outdated', 'corrected')):
        files = '--floorplan', folder / f'{plan}.yaml', '--submap', folder / 'robot.yaml'
        assert call('align', *files, '--out', folder / out, '--json', folder / f'{out}.json') == 0
    return folder


def report_of(folder, name='out'):
    return json.loads((folder / f'{name}.json').read_text(encoding='utf-8'))


def test_transform_is_right_to_a_few_centimetres(folder):
    report = report_of(folder)
    A = Affine2D.from_matrix(report['T_plan_map'])
    assert errors_m(A, CORNERS_MAP, CORNERS_PLAN) < 0.05
    assert errors_m(Affine2D.from_matrix(report['T_map_plan']), CORNERS_PLAN, CORNERS_MAP) < 0.05
    assert (report['parent_frame'], report['child_frame']) == ('plan', 'map')
    S = Affine2D.from_matrix(report['similarity_plan_map'])
    assert errors_m(S, CORNERS_MAP, CORNERS_PLAN) == pytest.approx(
        report['similarity_error_m'], abs=0.06
    )
    assert report['covariance']['sigma_x_m'] > 0.0
    assert report == report | json.loads((folder / 'out' / 'alignment.json').read_text())


def test_cloud_is_aligned_in_its_own_frame(folder, tmp_path):
    grid = submap_grid()
    floor, wall = (grid.rc_to_xy(np.argwhere(grid.cells == kind)) for kind in (FREE, OCCUPIED))
    layers = [np.column_stack([wall, np.full(len(wall), z)]) for z in np.arange(0.1, 2.6, 0.3)]
    ground = np.column_stack([floor, np.zeros(len(floor))])
    np.save(tmp_path / 'cloud.npy', np.concatenate([ground, *layers]))
    aligned = fpnet.align(folder / 'plan.yaml', tmp_path / 'cloud.npy')
    assert errors_m(aligned.A_plan_map, CORNERS_MAP, CORNERS_PLAN) < 0.08


def test_every_room_has_its_residual(folder):
    rooms = report_of(folder)['rooms']
    areas = sorted((x1 - x0 - 0.2) * (y1 - y0 - 0.2) for x0, y0, x1, y1 in (*ROOMS, (0, 5, 20, 7)))
    found = sorted(room['area_m2'] for room in rooms if room['room'] is not None)
    np.testing.assert_allclose(found, areas, rtol=0.1)
    assert max(room['median_m'] for room in rooms) <= 0.05
    assert min(room['explained'] for room in rooms) > 0.9
    assert report_of(folder)['deformation']['max_m'] < 0.1


def test_residuals_are_listed_under_the_names_of_rooms(folder, capsys):
    model = complete_model(fpnet.read_plan(folder / 'plan.yaml'))
    rooms = tuple(replace(room, name=f'2.{n}') for n, room in enumerate(model.rooms, start=10))
    write_model(replace(model, rooms=rooms), folder / 'named.geojson')
    files = '--floorplan', folder / 'named.geojson', '--submap', folder / 'robot.yaml'
    assert call('align', *files) == 0
    printed = capsys.readouterr().out
    assert [name for name in printed.split() if name.startswith('2.1')] != []
    assert all(room.name in printed for room in rooms)


def test_exported_maps_lie_on_each_other(folder):
    """The product places the warped robot map on the plan, and the robot map on the corrected."""
    out = folder / 'out'
    warped = fpnet.match(out / 'plan.yaml', out / 'robot_map_in_plan.yaml')
    assert errors_m(warped.A_plan_sub, CORNERS_PLAN, CORNERS_PLAN) < 0.06
    corrected = fpnet.match(out / 'corrected_plan.yaml', folder / 'robot.yaml')
    assert errors_m(corrected.A_plan_sub, CORNERS_MAP, CORNERS_MAP) < 0.06


def shares(grid, kind, box):
    """Share of the cells of a map in a box of the building that are of a kind."""
    rc = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing='ij'), axis=-1)
    building = A_BUILDING_PLAN.apply(A_PLAN_SUBMAP.apply(grid.rc_to_xy(rc)))
    return (grid.cells == kind)[inside(building, box)].mean()


def test_corrected_plan_has_the_walls_of_the_building(folder):
    corrected = read_map(folder / 'corrected' / 'corrected_plan.yaml')
    built = shares(submap_grid(), OCCUPIED, GONE_WALL)
    assert shares(corrected, OCCUPIED, GONE_WALL) > 0.8 * built
    assert all(shares(corrected, FREE, box) > 0.8 for box in OTHER_WALLS)
    layer = Image.open(folder / 'corrected' / 'corrected_plan_confidence.png')
    wrong, seen = np.moveaxis(np.asarray(layer)[::-1] / 255.0, -1, 0)
    wrong = replace(corrected, cells=np.where((seen > 0) & (wrong < 0.5), 100, 0).astype(np.int8))
    assert shares(wrong, 100, GONE_WALL) > 0.8 * built
    assert wrong.cells.mean() < 2.0  # per cent
    assert (seen == 0).any()


def test_corrected_dxf_has_the_walls_of_the_building(folder):
    plan = fpnet.read_plan(folder / 'corrected' / 'corrected_plan.dxf')
    found = fpnet.match(plan, folder / 'robot.yaml')
    assert found.status.value == 'matched'
    assert fpnet.align(plan, folder / 'robot.yaml').walls.whole['explained'] > 0.95
    document = ezdxf.readfile(folder / 'corrected' / 'corrected_plan.dxf')
    points = [p[:2] for line in document.modelspace().query('LWPOLYLINE') for p in line]
    building = A_BUILDING_PLAN.apply(A_PLAN_SUBMAP.apply(np.array(points)))
    assert building.min() > -0.6
    assert (building.max(axis=0) < (20.6, 13.6)).all()


def test_open_rmf_building_has_the_robot_map_as_a_layer(folder):
    path = folder / 'out' / 'aligned.building.yaml'
    level = yaml.safe_load(path.read_text(encoding='utf-8'))['levels']['L1']
    layer = level['layers']['robot_map']
    height, width = read_map(folder / 'out' / 'robot_map.yaml').shape
    assert Image.open(path.with_name(layer['filename'])).size == (width, height)
    # As the traffic editor: pixels from the upper left corner, to metres right and down.
    t, grid = layer['transform'], submap_grid()
    local = grid.T_frame_grid.inv().apply(CORNERS_MAP) / grid.resolution
    right, down = local[:, 0], height - local[:, 1]
    c, s = np.cos(t['yaw']), np.sin(t['yaw'])
    x = t['scale'] * (c * right + s * down) + t['translation_x']
    y = t['scale'] * (-s * right + c * down) + t['translation_y']
    plan = plan_grid()
    drawn = plan.T_frame_grid.inv().apply(CORNERS_PLAN)
    truth = np.stack([drawn[:, 0], plan.shape[0] * plan.resolution - drawn[:, 1]], axis=1)
    off_m = np.linalg.norm(np.stack([x, y], axis=1) - truth, axis=1).max()
    assert off_m < report_of(folder)['similarity_error_m'] + 0.06
    (storey,) = read_open_rmf(path, FpnetConfig()).storeys
    assert storey.plan.scale.resolution_m == pytest.approx(0.05)
    assert len(storey.doors) == 6
    assert len(fpnet.segment(path).rooms) == 7


def symmetric(grid, A_building_frame):
    """A map of the building whose right half mirrors the left one."""
    rc = np.stack(np.meshgrid(*map(np.arange, grid.shape), indexing='ij'), axis=-1)
    x, y = np.moveaxis(A_building_frame.apply(grid.rc_to_xy(rc)), -1, 0)
    return replace(grid, cells=building_cells(np.stack([np.minimum(x, 22.0 - x), y], axis=-1)))


def refused(folder, out, *words):
    """Report of a call that must be refused without writing a file."""
    files = '--floorplan', out / 'plan.yaml', '--submap', folder / 'robot.yaml'
    call_words = ('align', *files, '--out', out / 'out', '--json', out / 'out.json', *words)
    assert call(*call_words) == NO_ANSWER
    assert not (out / 'out').exists()
    report = report_of(out)
    assert report['status'] != 'matched'
    assert 'T_plan_map' not in report
    return report


def test_mirrored_drawing_is_refused_and_says_what_to_do(folder, tmp_path, capsys):
    write_map(plan_grid().mirrored(), tmp_path / 'plan.yaml')
    (cause,) = refused(folder, tmp_path)['causes']
    assert cause['cause'] == 'floorplan mirrored'
    assert cause['next'].startswith('fpnet align')
    assert cause['next'].endswith('--mirrored')
    assert cause['next'] in capsys.readouterr().out
    files = '--floorplan', tmp_path / 'plan.yaml', '--submap', folder / 'robot.yaml'
    assert call('align', *files, '--mirrored') == 0


def test_mirror_image_that_fits_as_well_is_refused(tmp_path):
    write_map(symmetric(plan_grid(), A_BUILDING_PLAN), tmp_path / 'plan.yaml')
    seen = symmetric(submap_grid(), A_BUILDING_PLAN @ A_PLAN_SUBMAP)
    write_map(seen, tmp_path / 'robot.yaml')
    strict = '--set=localizer.match_probability=0.997'  # one drawing in 200 is mirrored
    assert '--mirrored' in refused(tmp_path, tmp_path, strict)['reason']


def test_another_building_is_refused(folder, tmp_path):
    grid = plan_grid()
    write_map(
        replace(grid, cells=building_cells(building_xy(grid) * (0.6, 1.6))), tmp_path / 'plan.yaml'
    )
    assert refused(folder, tmp_path)['causes'] != []
    with pytest.raises(NotPlacedError, match='not placed'):
        fpnet.align(tmp_path / 'plan.yaml', folder / 'robot.yaml')


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (('--floorplan', 'plan.yaml', '--submap', 'none.yaml'), 'none.yaml does not exist'),
        (('--submap', 'robot.yaml'), 'give either --floorplan or --site'),
        (
            ('--floorplan', 'plan.yaml', '--submap', 'robot.yaml', '--out', 'plan.yaml'),
            'is a file',
        ),
        (
            ('--floorplan', 'plan.yaml', '--submap', 'robot.yaml', '--submap-storey', '2'),
            'only clouds have several',
        ),
    ],
)
def test_wrong_input_is_one_line(folder, words, said, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    assert call('align', *words) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
