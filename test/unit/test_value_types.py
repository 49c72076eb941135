# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values refuse to be built wrong, and configuration errors name the key."""

import numpy as np
import pytest

from fpnet_core.config import FpnetConfig, load_config
from fpnet_core.errors import ConfigError
from fpnet_core.geometry import SE2
from fpnet_core.matches import MatchResult
from fpnet_core.types import (
    GridMap,
    LocalizerOutput,
    Portal,
    Region,
    RegionGraph,
    RegionLabel,
    Segmentation,
    Status,
    Submap,
)

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
GRID = GridMap(np.zeros((4, 6), dtype=np.int8), 0.1)


def room(number=0, **changes):
    values = {'polygon': SQUARE, 'centroid': [1.0, 0.5], 'area_m2': 2.0, **changes}
    return Region(number, RegionLabel.ROOM, **values)


@pytest.mark.parametrize(
    ('make', 'message'),
    [
        (lambda: GridMap(np.full((2, 2), 50, np.int8), 0.1), '0, 100 or -1'),
        (lambda: GridMap(np.zeros((0, 2), np.int8), 0.1), 'no cells'),
        (lambda: GridMap(np.zeros((2, 2), np.int8), 0.0), 'positive'),
        (lambda: GridMap(np.zeros(4, np.int8), 0.1), 'shape'),
        (lambda: Submap(GRID, np.zeros((6, 4), bool), np.zeros((0, 2))), 'lintel'),
        (lambda: room(polygon=SQUARE[:2]), 'three vertices'),
        (lambda: room(area_m2=0.0), 'positive area'),
        (lambda: room(observed_fraction=1.5), r'observed_fraction.*\[0, 1\]'),
        (lambda: room(centroid=[np.nan, 0.0]), 'NaN'),
        (lambda: MatchResult([[0, 1], [0, 2]], [0.5, 0.5], np.zeros((3, 3))), 'one-to-one'),
        (lambda: LocalizerOutput(0, Status.LOCALIZED), 'go together'),
        (lambda: LocalizerOutput(0, Status.LOST, SE2.identity()), 'go together'),
    ],
)
def test_a_wrong_value_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_portal_must_name_a_door():
    portal = Portal(0, (0, None), np.array([[0.0, 0.0], [0.9, 0.0]]))
    labels = np.zeros(GRID.shape, dtype=np.int32)
    with pytest.raises(ValueError, match='not a door'):
        Segmentation(GRID, labels, (room(),), (portal,))
    assert portal.width_m == pytest.approx(0.9)


def test_region_ids_are_positions():
    with pytest.raises(ValueError, match='positions'):
        Segmentation(GRID, np.zeros(GRID.shape, np.int32), (room(3),), ())


def test_edges_must_name_regions():
    with pytest.raises(ValueError, match='does not exist'):
        RegionGraph((room(),), [[0, 1]], np.zeros((1, 28)), np.zeros((1, 2)), 'plan')


def test_arrays_are_read_only_copies():
    cells = np.zeros((2, 2), dtype=np.int8)
    grid = GridMap(cells, 0.1)
    cells[0, 0] = 100
    assert grid.cells[0, 0] == 0
    with pytest.raises(ValueError, match='read-only'):
        grid.cells[0, 0] = 100


def test_mirroring_reverses_the_columns():
    grid = GridMap(np.array([[0, 100, -1]], dtype=np.int8), 0.1)
    assert grid.mirrored().cells.tolist() == [[-1, 100, 0]]


def test_overrides_reach_their_section():
    assert load_config(None, {'submap.resolution_m': 0.1}).submap.resolution_m == 0.1


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('submap: {resolution: 0.1}', 'submap.resolution'),
        ('submap: {resolution_m: 9}', 'submap.resolution_m'),
        ('[1, 2]', 'expected a mapping'),
        ('a: [', 'not valid YAML'),
        ('!!python/object/apply:os.system ["true"]', 'not valid YAML'),
    ],
)
def test_a_bad_configuration_names_the_key(tmp_path, text, message):
    path = tmp_path / 'bad.yaml'
    path.write_text(text)
    with pytest.raises(ConfigError, match=message):
        load_config(path)


def test_ros_parameter_files_and_plain_ones_read_alike(tmp_path):
    plain, ros = tmp_path / 'plain.yaml', tmp_path / 'ros.yaml'
    plain.write_text('seed: 4\n')
    ros.write_text('/**:\n  ros__parameters:\n    seed: 4\n')
    assert load_config(plain) == load_config(ros) == FpnetConfig(seed=4)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r'none\.yaml'):
        load_config(tmp_path / 'none.yaml')


def test_a_cropped_map_leaves_its_cells_where_they_are():
    cells = np.arange(24).reshape(4, 6) % 2 * 100
    grid = GridMap(cells, 0.1, SE2.from_xy_yaw(3.0, -2.0, 0.7))
    part = grid.cropped(slice(1, 3), slice(2, 6))
    assert (part.cells == cells[1:3, 2:6]).all()
    assert np.allclose(part.rc_to_xy([[1, 3]]), grid.rc_to_xy([[2, 5]]))
