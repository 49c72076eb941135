# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sites from files: our YAML, folders of maps, Open-RMF buildings, and errors that help."""

from itertools import starmap

import cv2
import numpy as np
from planted import ROOMS, plan_grid
import pytest
import yaml

from fpnet_core.errors import FpnetError, MapFormatError, SiteError
from fpnet_core.io.maps import write_map
from fpnet_core.sites import Link, LinkKind, Site, Storey
from fpnet_core.sites.site_files import read_site

TWO = {
    'site': 'tower',
    'storeys': [
        {'name': 'L0', 'plan': 'a.yaml', 'level': 0, 'elevation': 0.0, 'pose': [1, 2, 90]},
        {'name': 'L1', 'plan': 'b.yaml', 'level': 1, 'elevation': 3.5},
    ],
    'links': [{'name': 'A', 'kind': 'lift', 'at': {'L0': [1.0, 2.0], 'L1': [3, 4]}}],
}


@pytest.fixture
def folder(tmp_path):
    for name in ('a', 'b'):
        write_map(plan_grid(), tmp_path / f'{name}.yaml')
    return tmp_path


def written(folder, values, name='site.yaml'):
    path = folder / name
    path.write_text(yaml.safe_dump(values), encoding='utf-8')
    return path


def test_our_yaml(folder):
    site = read_site(written(folder, TWO))
    assert (site.name, site.names) == ('tower', ('L0', 'L1'))
    low, high = site.storeys
    assert (low.level, low.elevation_m, high.elevation_m) == (0, 0.0, 3.5)
    assert high.T_site_plan is None
    assert low.T_site_plan.yaw == pytest.approx(np.pi / 2)
    assert low.T_site_plan.translation.tolist() == [1.0, 2.0]
    np.testing.assert_array_equal(low.plan.grid.cells, plan_grid().cells)
    (link,) = site.linked('L1')
    assert link.kind is LinkKind.LIFT
    assert link.at['L1'].tolist() == [3.0, 4.0]


def test_a_folder_is_its_site_yaml_or_its_maps(folder):
    bare = read_site(folder)
    assert bare.names == ('a', 'b')
    assert [storey.level for storey in bare.storeys] == [0, 1]
    written(folder, TWO)
    assert read_site(folder).names == ('L0', 'L1')


PARAMETERS = 'amcl:\n  ros__parameters:\n    image: &anchor 1\n    other: *anchor\n'


def test_a_folders_other_yamls_are_named_once_and_a_damaged_map_is_an_error(folder, caplog):
    (folder / 'nav2_params.yaml').write_text(PARAMETERS)
    (folder / 'metadata.yaml').write_text('rosbag2_bagfile_information: {version: 5}\n')
    assert read_site(folder).names == ('a', 'b')
    said, levels = caplog.messages
    assert 'the names give no level: a, b;' in levels
    assert 'metadata.yaml' in said
    assert 'nav2_params.yaml' in said
    assert str(folder / 'a.yaml') not in said
    whole = (folder / 'b.yaml').read_text()
    for damaged in ('', 'image: [', whole.replace('resolution', 'resolutoin')):
        (folder / 'b.yaml').write_text(damaged)
        with pytest.raises(MapFormatError, match="storey 'b'"):
            read_site(folder)
    (folder / 'b.png').unlink()
    (folder / 'b.yaml').write_text(whole)
    with pytest.raises(MapFormatError, match=r'b\.png does not exist'):
        read_site(folder)


def test_one_floorplan_is_a_site_of_one(folder):
    assert read_site(folder / 'a.yaml').names == ('a',)


def test_names_carry_the_building_where_there_are_several(folder):
    storeys = [
        {'name': 'L0', 'plan': 'a.yaml', 'building': 'north'},
        {'name': 'L0', 'plan': 'b.yaml', 'building': 'south'},
    ]
    assert read_site(written(folder, {'storeys': storeys})).names == ('north/L0', 'south/L0')


def test_a_mirrored_storey_is_flipped(folder):
    storeys = [{'name': 'L0', 'plan': 'a.yaml', 'mirrored': True}]
    (storey,) = read_site(written(folder, {'storeys': storeys})).storeys
    np.testing.assert_array_equal(storey.plan.grid.cells, plan_grid().cells[:, ::-1])


def test_what_is_said_of_a_drawing_is_said_of_a_storey(folder):
    cells = np.array([[0, 0], [240, 0]]) + 30.0
    storeys = [{'name': 'L0', 'plan': 'a.yaml', 'length': [*cells.ravel().tolist(), 24.0]}]
    (storey,) = read_site(written(folder, {'storeys': storeys})).storeys
    assert storey.plan.scale.resolution_m == pytest.approx(0.1)
    for said in ({'page': 2}, {'layers': ['WALLS']}):
        one = {'name': 'L0', 'plan': 'a.yaml', **said}
        with pytest.raises(MapFormatError, match=f'{next(iter(said))} does not apply'):
            read_site(written(folder, {'storeys': [one]}))


def changed(key, value):
    return {**TWO, key: value}


@pytest.mark.parametrize(
    ('values', 'named'),
    [
        ([], 'expected a mapping'),
        (changed('storey', 1), "unknown key 'storey'"),
        (changed('storeys', []), 'there is no storey'),
        (changed('storeys', [{'plan': 'a.yaml'}]), 'storey 1: expected name'),
        (changed('storeys', [{'name': 'x'}]), 'storey 1: expected plan'),
        (changed('storeys', [{'name': 'x', 'plan': 'no.png'}]), r"storey 'x': .*no.png does not"),
        (
            changed('storeys', [{'name': 'x', 'plan': f'{plan}.yaml'} for plan in 'ab']),
            "2 storeys are called 'x'",
        ),
        (
            changed('storeys', [{'name': 'x', 'plan': 'a.yaml', 'elevation': 'high'}]),
            "'x': elevation: expected metres, got 'high'",
        ),
        (
            changed('storeys', [{'name': 'x', 'plan': 'a.yaml', 'pose': [1, 2]}]),
            "'x': pose: expected",
        ),
        (
            changed('storeys', [{'name': 'x', 'plan': 'a.yaml', 'resolution': -1}]),
            'resolution must be positive metres per pixel',
        ),
        (
            changed('storeys', [{'name': 'x', 'plan': 'a.yaml', 'mirrored': 'false'}]),
            "mirrored: expected true or false, got 'false'",
        ),
        (
            changed('storeys', [{'name': 'x', 'plan': 'a.yaml', 'page': 1.5}]),
            'page: expected a whole number, got 1.5',
        ),
        (changed('links', [{'at': {'L0': [1, 2], 'L7': [1, 2]}}]), "stops at 'L7', which is no"),
        (changed('links', [{'at': {'L0': [1, 2]}}]), 'needs two or more'),
        (changed('links', [{'kind': 'rope', 'at': {}}]), 'expected lift or stairs'),
        (changed('links', [{'at': {'L0': [1], 'L1': [1, 2]}}]), r"at 'L0': expected \[x, y\]"),
    ],
)
def test_errors_name_what_is_wrong(folder, values, named):
    with pytest.raises(FpnetError, match=named) as caught:
        read_site(written(folder, values))
    assert '\n' not in str(caught.value)


def test_what_is_not_there_is_named(tmp_path):
    with pytest.raises(SiteError, match='does not exist'):
        read_site(tmp_path / 'none')
    with pytest.raises(SiteError, match=r'has no site\.yaml'):
        read_site(tmp_path)


# ---- Open-RMF

PIXEL_M = 0.04


def drawing(path, angle_deg=0.0):
    """A picture of the planted building, y down; returns building metres to pixels."""
    size = (620, 460)
    image = np.full((size[1], size[0], 3), 255, np.uint8)
    turn = cv2.getRotationMatrix2D((310, 230), angle_deg, 1.0)

    def pixel(x, y):
        return turn @ np.array([60 + x / PIXEL_M, 400 - y / PIXEL_M, 1.0])

    for x0, y0, x1, y1 in (*ROOMS, (0, 5, 20, 7)):
        corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
        ring = np.rint([pixel(x, y) for x, y in corners]).astype(np.int32)
        cv2.polylines(image, [ring], True, (0, 0, 0), 4)
    for x, y in ((3, 5), (9, 5), (17.3, 5), (2, 7), (8, 7), (15.5, 7)):
        ends = [tuple(np.rint(pixel(x + dx, y)).astype(int).tolist()) for dx in (-0.45, 0.45)]
        cv2.line(image, *ends, (255, 255, 255), 8)
    cv2.imwrite(str(path), image)
    return pixel


def rmf(folder):
    levels = {}
    for number, (name, angle) in enumerate((('L1', 0.0), ('L2', 3.0))):
        pixel = drawing(folder / f'{name}.png', angle)
        places = [pixel(0, 0), pixel(20, 0), pixel(0, 13), pixel(2.55, 5), pixel(3.45, 5)]
        levels[name] = {
            'drawing': {'filename': f'{name}.png'},
            'elevation': 4.0 * number,
            'vertices': [[*p.tolist(), 0, ''] for p in places],
            'measurements': [[0, 1, {'distance': [3, 20.0]}], [0, 2, {'distance': [3, 13.0]}]],
            'fiducials': [[*p.tolist(), f'corner{k}'] for k, p in enumerate(places[:3])],
            'doors': [[3, 4, {'name': [1, 'office'], 'type': [1, 'hinged']}]],
            'walls': [],
        }
    x, y = drawing(folder / 'L1.png')(10, 6).tolist()
    lift = {
        'reference_floor_name': 'L1', 'x': x, 'y': y,
        'level_doors': {'L1': ['front'], 'L2': ['front']},
    }  # fmt: skip
    return {'name': 'hotel', 'levels': levels, 'lifts': {'main': lift}}


def test_an_open_rmf_building(tmp_path):
    site = read_site(written(tmp_path, rmf(tmp_path), 'hotel.building.yaml'))
    assert (site.name, site.names) == ('hotel', ('L1', 'L2'))
    assert [storey.elevation_m for storey in site.storeys] == [0.0, 4.0]
    assert [storey.level for storey in site.storeys] == [0, 1]
    for storey in site.storeys:
        assert storey.plan.scale.is_known
        assert storey.plan.scale.resolution_m == pytest.approx(PIXEL_M, rel=1e-3)
        (door,) = storey.doors
        assert door.name == 'office'
        assert np.linalg.norm(door.ends[1] - door.ends[0]) == pytest.approx(0.9, abs=0.02)
    (lift,) = site.links
    # The same place on both plans, which are turned against each other.
    below = site.storeys[0].T_site_plan.apply(lift.at['L1'])
    above = site.storeys[1].T_site_plan.apply(lift.at['L2'])
    np.testing.assert_allclose(above, below, atol=1e-6)
    first, second = (storey.doors[0].ends.mean(axis=0) for storey in site.storeys)
    for storey, door in zip(site.storeys, (first, second), strict=True):
        apart = np.linalg.norm(lift.at[storey.name] - door)
        assert apart == pytest.approx(np.hypot(7.0, 1.0), abs=0.05)


@pytest.mark.parametrize(
    ('damage', 'named'),
    [
        (lambda v: v['levels']['L2'].pop('measurements'), "level 'L2': it has no measurement"),
        (lambda v: v['levels']['L2']['drawing'].update(filename='no.png'), "level 'L2': .*no.png"),
        (lambda v: v.update(coordinate_system='web_mercator'), 'is not in pixels of the drawings'),
        (
            lambda v: v['lifts']['main'].update(reference_floor_name='L9'),
            "'L9', which is not a level",
        ),
        (lambda v: v['levels']['L1']['doors'].append([3, 99, {}]), 'edge from vertex 3 to 99'),
        (lambda v: v.update(reference_level_name='B'), "reference_level_name is 'B'"),
    ],
)
def test_errors_of_open_rmf_name_what_is_wrong(tmp_path, damage, named):
    values = rmf(tmp_path)
    damage(values)
    with pytest.raises((SiteError, MapFormatError), match=named):
        read_site(written(tmp_path, values, 'hotel.building.yaml'))


def test_a_site_knows_its_storeys():
    a, b = starmap(Storey, (('a', None), ('b', None)))
    site = Site('s', (a, b), (Link('x', LinkKind.STAIRS, {'a': np.zeros(2), 'b': np.ones(2)}),))
    assert site.storey('b') is b
    assert len(site.linked('a')) == 1
    with pytest.raises(SiteError, match="no storey 'c'; expected one of a, b"):
        site.storey('c')
