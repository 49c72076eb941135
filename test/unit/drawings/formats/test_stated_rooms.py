# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rooms and doors that a file states are the regions that a robot is localised by."""

from importlib.util import find_spec

import numpy as np
import pytest
import shapely
import test_drawings_geojson as imdf
import test_ifc_elements as ifc

from fpnet_core.config import FpnetConfig
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.maps import cut_of
from fpnet_core.sites import Site, Storey
from fpnet_core.sites.storey_plans import storey_plans

CONFIG = FpnetConfig()

needs_ifc = pytest.mark.skipif(
    find_spec('ifcopenshell') is None, reason='IfcOpenShell is an optional extra'
)


@pytest.fixture(params=['imdf', pytest.param('ifc', marks=needs_ifc)])
def reading(request, tmp_path):
    module = {'imdf': imdf, 'ifc': ifc}[request.param]
    return module.read(module.write(tmp_path / f'a.{request.param}'.replace('.imdf', '')))


def regions_of_localizer(reading):
    (given,) = storey_plans(Site('', (Storey('', reading),)), CONFIG)
    plan = Floorplan.prepared(given.grid, CONFIG, given.scale, given.policy, given.segmentation)
    return plan.working


def test_rooms_and_doors_are_one_to_one(reading):
    side, model = regions_of_localizer(reading), reading.model
    rooms = side.segmentation.rooms
    areas = [shapely.Polygon(room.rings[0]) for room in model.rooms]
    middles = [shapely.Point(room.centroid) for room in rooms]
    owners = [[k for k, area in enumerate(areas) if area.contains(xy)] for xy in middles]
    assert sorted(owners) == [[k] for k in range(len(model.rooms))]
    for room, (owner,) in zip(rooms, owners, strict=True):
        assert room.area_m2 == pytest.approx(model.rooms[owner].area_m2, rel=0.06)
    ends = sorted(portal.ends.mean(axis=0).tolist() for portal in side.segmentation.portals)
    stated = sorted(door.ends.mean(axis=0).tolist() for door in model.doors)
    np.testing.assert_allclose(ends, stated, atol=1e-6)
    assert len(side.graph.edges) == 2 * len(model.doors)


def test_whoever_takes_a_reading_takes_them(reading):
    known = [room.area_m2 for room in reading.segmentation.rooms]
    simple = FpnetConfig.model_validate({'segmentation': {'method': 'distance'}})
    for config in (CONFIG, simple):
        assert [room.area_m2 for room in cut_of(reading, config).segmentation.rooms] == known
    flipped = reading.flipped().segmentation
    assert [room.area_m2 for room in flipped.rooms] == pytest.approx(known)
    width_m = reading.grid.shape[1] * reading.grid.resolution
    for portal, mirrored in zip(reading.segmentation.portals, flipped.portals, strict=True):
        np.testing.assert_allclose(mirrored.ends, [width_m, 0.0] + portal.ends * [-1.0, 1.0])


@needs_ifc
def test_rooms_without_a_wall_between_them_have_an_opening(tmp_path):
    rooms = ((0.3, 0.3, 3.9, 4.4), (4.2, 0.3, 3.5, 4.4))
    reading = ifc.read(ifc.write(tmp_path / 'a.ifc', ifc.WALLS[:4], rooms, None))
    (portal,) = reading.segmentation.portals
    assert set(portal.rooms) == {0, 1}
    assert portal.width_m == pytest.approx(4.4, abs=0.1)
