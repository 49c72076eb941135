# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from typer.testing import CliRunner

from fpnet_core.errors import ConfigError, FpnetError, MapFormatError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.io.maps import write_map
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, RegionLabel
from fpnet_lab.cli.simulate import app
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.drawn.distort import warp_map
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.pairs.dataset import PairDataset, read_manifest
from fpnet_lab.sim.pairs.pair import generate_mapped_pair, generate_pair
from fpnet_lab.sim.pairs.presets import PRESETS, in_split, preset
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.plans.sources import GivenPlans

SMALL = SimConfig(pairs_per_plan=2, pairs_per_drawing=2)


def _house(seed):
    return render_plan(generate_plan(np.random.default_rng(seed), 'house'), 0.05)


@pytest.fixture(scope='module')
def source():
    return GivenPlans([('first', _house(4)), ('second', _house(6))])


def test_pairs_of_a_given_plan_fit_its_own_raster(source):
    mapped = generate_mapped_pair(3, 0, SMALL, source)
    labels = mapped.pair.sub_labels
    assert np.count_nonzero(labels >= 0) >= 2
    rc = np.argwhere(mapped.submap.grid.cells == FREE)
    xy = mapped.pair.A_plan_submap.apply(mapped.submap.grid.rc_to_xy(rc))
    grid = mapped.plan_segmentation.grid
    target = np.rint(grid.xy_to_rc(xy)).astype(int)
    inside = ((target >= 0) & (target < grid.shape)).all(axis=1)
    assert (grid.cells[tuple(target[inside].T)] == FREE).mean() > 0.85


@pytest.mark.parametrize('degrees', [0.0, 13.0, 45.0, 71.0])
def test_walls_of_one_cell_stay_closed_at_any_angle(degrees):
    cells = np.full((60, 60), FREE, np.int8)
    cells[[0, -1, 30], :] = cells[:, [0, -1]] = OCCUPIED
    A = Affine2D(SE2.from_xy_yaw(0.0, 0.0, np.deg2rad(degrees)).linear, np.zeros(2))
    turned = warp_map(GridMap(cells, 0.05), A)
    config = SMALL.segmentation.model_copy(update={'min_room_area_m2': 0.5})
    assert len(segment_floorplan(turned, config).rooms) == 2


def test_a_plan_without_rooms_is_one_clear_line():
    with pytest.raises(MapFormatError, match='blank: the floorplan has no rooms'):
        GivenPlans([('blank', GridMap(np.full((40, 40), UNKNOWN, np.int8), 0.05))])
    with pytest.raises(MapFormatError, match='no floorplan was given'):
        GivenPlans([])


def test_a_single_closed_room_is_one_clear_line():
    cells = np.full((80, 100), OCCUPIED, np.int8)
    cells[2:-2, 2:-2] = FREE
    with pytest.raises(MapFormatError, match='cell: the floorplan has 1 room, expected 2'):
        GivenPlans([('cell', GridMap(cells, 0.05))])


def test_tours_that_see_too_little_are_one_clear_line(monkeypatch):
    monkeypatch.setattr('fpnet_lab.sim.pairs.pair.MIN_SUB_REGIONS', 99)
    monkeypatch.setattr('fpnet_lab.sim.pairs.pair._ATTEMPTS', 2)
    with pytest.raises(FpnetError, match='no tour in 2 saw 99 regions'):
        generate_pair(0, 0, SMALL, GivenPlans([('cell', _house(4))]))


def test_presets_are_the_papers():
    assert PRESETS['paper-synthetic'].pair_count(0) == 25000
    assert PRESETS['paper-real'].pair_count(20) == 1000
    assert PRESETS['paper-challenging'].config.drawing.cut == 1.0
    assert PRESETS['default'].pair_count(0) is None
    with pytest.raises(ConfigError, match="no preset 'x'; expected one of default"):
        preset('x')


def test_splits_choose_by_name():
    plans = [('office_a', _house(4)), ('office_f', _house(4))]
    assert [name for name, _ in in_split(plans, 'report')] == ['office_f']
    with pytest.raises(ConfigError, match='no split'):
        in_split(plans, 'test')
    with pytest.raises(ConfigError, match='is a tune storey: lab_a_scan'):
        in_split(plans[1:], 'tune')


def _run(*arguments):
    return CliRunner().invoke(app, ['pairs', *map(str, arguments)])


def test_the_command_makes_pairs_of_my_plan(tmp_path):
    write_map(_house(4), tmp_path / 'mine.yaml')
    result = _run('--out', tmp_path / 'out', '--count', 2, '--floorplan', tmp_path / 'mine.yaml')
    assert result.exit_code == 0, result.output
    assert len(PairDataset(tmp_path / 'out')) == 2
    assert list(read_manifest(tmp_path / 'out')['source']['plans']) == ['mine']
    graph = PairDataset(tmp_path / 'out').pair(0).plan_graph
    assert any(region.label is RegionLabel.DOOR for region in graph.regions)


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (['--preset', 'paper-real'], 'needs real floorplans; give --plans PATH'),
        ([], 'has no default number of pairs; give --count'),
        (['--split', 'tune', '--count', 1], 'give --plans PATH'),
        (['--floorplan', 'absent.png', '--count', 1], 'absent.png does not exist'),
    ],
)
def test_impossible_requests_are_refused(tmp_path, arguments, message):
    result = _run('--out', tmp_path / 'out', *arguments)
    assert isinstance(result.exception, FpnetError)
    assert message in str(result.exception)
