# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""IFC: a building of two storeys that this test makes itself; skipped without IfcOpenShell."""

from importlib.util import find_spec
import subprocess
import sys

import numpy as np
from plan_files import levels
import pytest

from fpnet_core.drawings.opening import open_drawing
from fpnet_core.drawings.types import ReadOptions, ScaleSource
from fpnet_core.errors import MapFormatError

needs_library = pytest.mark.skipif(
    find_spec('ifcopenshell') is None, reason='IfcOpenShell is an optional extra'
)


def write_building(path):
    """Write two storeys of 8 m x 5 m in millimetres; the lower one has a door and a high sill."""
    import ifcopenshell
    from ifcopenshell.api import run

    model = run('project.create_file')
    project = run('root.create_entity', model, ifc_class='IfcProject', name='P')
    run('unit.assign_unit', model, length={'is_metric': True, 'raw': 'MILLIMETERS'})
    context = run('context.add_context', model, context_type='Model')
    body = run(
        'context.add_context', model, context_type='Model', context_identifier='Body',
        target_view='MODEL_VIEW', parent=context,
    )  # fmt: skip
    building = run('root.create_entity', model, ifc_class='IfcBuilding', name='B')
    run('aggregate.assign_object', model, products=[building], relating_object=project)
    for name, floor in (('Ground', 0.0), ('First', 3.0)):
        storey = run('root.create_entity', model, ifc_class='IfcBuildingStorey', name=name)
        run('aggregate.assign_object', model, products=[storey], relating_object=building)
        storey.Elevation = 1000.0 * floor
        run('geometry.edit_object_placement', model, product=storey, matrix=_at(0, 0, floor))
        long = [(0, 0, 8, 0.3), (0, 4.7, 8, 0.3)]
        short = [(0, 0.3, 0.3, 4.4), (7.7, 0.3, 0.3, 4.4)]
        extra = [(4, 0.3, 0.2, 4.4)] if floor == 0.0 else []
        for x, y, dx, dy in [*long, *short, *extra]:
            wall = _box(model, run, body, storey, 'IfcWall', (x, y, floor), (dx, dy, 2.8))
            if (x, floor) == (4, 0.0):
                _cut(model, run, body, wall, (x - 0.5, 2.0, floor), (1.5, 0.9, 2.1))
            if (x, y, floor) == (0, 0, 0.0):
                _cut(model, run, body, wall, (1.0, -0.5, floor + 2.0), (2.0, 1.5, 0.5))
    model.write(str(path))
    assert isinstance(model, ifcopenshell.file)
    return path


def _at(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def _shape(model, run, body, product, at, size):
    dx, dy, dz = (1000.0 * side for side in size)
    profile = model.createIfcRectangleProfileDef(
        'AREA', None,
        model.createIfcAxis2Placement2D(model.createIfcCartesianPoint((dx / 2, dy / 2))), dx, dy,
    )  # fmt: skip
    place = model.createIfcAxis2Placement3D(model.createIfcCartesianPoint((0.0, 0.0, 0.0)))
    up = model.createIfcDirection((0.0, 0.0, 1.0))
    solid = model.createIfcExtrudedAreaSolid(profile, place, up, dz)
    shape = model.createIfcShapeRepresentation(body, 'Body', 'SweptSolid', [solid])
    run('geometry.assign_representation', model, product=product, representation=shape)
    run('geometry.edit_object_placement', model, product=product, matrix=_at(*at))


def _box(model, run, body, storey, kind, at, size):
    element = run('root.create_entity', model, ifc_class=kind)
    run('spatial.assign_container', model, products=[element], relating_structure=storey)
    _shape(model, run, body, element, at, size)
    return element


def _cut(model, run, body, wall, at, size):
    opening = run('root.create_entity', model, ifc_class='IfcOpeningElement')
    _shape(model, run, body, opening, at, size)
    run('feature.add_feature', model, feature=opening, element=wall)


@pytest.mark.usefixtures('own_process')
@needs_library
def test_a_storey_is_cut_a_metre_above_its_floor(tmp_path):
    drawing = open_drawing(write_building(tmp_path / 'a.ifc'))
    assert 'storey 1 of 2 from below: Ground' in drawing.notes
    walls = [(2.0, 0.15), (0.15, 2.5), (7.85, 4.0), (4.1, 1.0), (4.1, 4.0), (6.0, 4.85)]
    assert (levels(drawing, walls) == 0).all()
    assert (levels(drawing, [(2.0, 2.5), (6.0, 2.5), (4.1, 2.45)]) == 255).all()
    pixels_per_m = np.sqrt(abs(np.linalg.det(drawing.A_pixel_image[:, :2])))
    assert drawing.scale.source is ScaleSource.UNITS
    assert drawing.scale.resolution_m * pixels_per_m == pytest.approx(1.0)
    assert drawing.doubts == ()


@needs_library
def test_storeys_by_number(tmp_path):
    path = write_building(tmp_path / 'a.ifc')
    upper = open_drawing(path, ReadOptions(page=2))
    assert 'storey 2 of 2 from below: First' in upper.notes
    assert levels(upper, [(4.1, 1.0), (0.15, 2.5)]).tolist() == [255.0, 0.0]
    with pytest.raises(MapFormatError, match='2 storeys; there is no storey 3'):
        open_drawing(path, ReadOptions(page=3))


@pytest.mark.usefixtures('own_process')
@needs_library
@pytest.mark.parametrize('rest', ['nonsense', "FILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\nENDSEC;\n"])
def test_bad_files_are_refused_in_a_line(tmp_path, rest):
    (tmp_path / 'a.ifc').write_text(f'ISO-10303-21;\nHEADER;\n{rest}END-ISO-10303-21;\n')
    with pytest.raises(MapFormatError, match=r'\Aa\.ifc [^\n]*\Z'):
        open_drawing(tmp_path / 'a.ifc')


def test_without_the_library_a_line_says_how_to_install_it():
    code = (
        'import sys; sys.modules["ifcopenshell"] = None\n'
        'from fpnet_core.drawings.formats.ifc import load_libraries\n'
        'from fpnet_core.errors import MapFormatError\n'
        'try:\n    load_libraries()\n'
        'except MapFormatError as error:\n    print(error)'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert "pip install 'fpnet_ros[ifc]'" in done.stdout
