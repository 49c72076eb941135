# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Arguments of the Python interface: wrong ones are named in one line, right ones go through."""

from pathlib import Path

import numpy as np
from planted import plan_grid
import pytest

import fpnet
from fpnet_core.io.maps import write_map

NO_FILE = r'^no\.png does not exist'


@pytest.mark.parametrize(
    ('arguments', 'named'),
    [
        ({'resolution': '0.05'}, "resolution: expected float or None, got '0.05'"),
        ({'resolution': True}, 'resolution: expected float or None, got True'),
        ({'length': '1,2,3,4=5'}, 'length: expected (float, float, float, float, float) or None'),
        ({'length': (1, 2, 3, 4)}, 'length: expected (float, float, float, float, float) or None'),
        ({'crop': np.array([0, 0, 9, 9])}, 'crop: expected (int, int, int, int) or None'),
        ({'crop': (0, 0, 1.5, 9)}, 'crop: expected (int, int, int, int) or None'),
        ({'storey': 1.0}, 'storey: expected int or None, got 1.0'),
        ({'layers': 'WALLS'}, "layers: expected several str, got 'WALLS'"),
        ({'layers': [1]}, 'layers: expected several str, got [1]'),
        ({'mirrored': 'no'}, "mirrored: expected bool, got 'no'"),
        ({'config': 'fpnet.yaml'}, 'config: expected FpnetConfig or None'),
    ],
)
def test_what_is_wrong_of_a_drawing_is_named(arguments, named):
    with pytest.raises(fpnet.FpnetError) as caught:
        fpnet.read_plan('no.png', **arguments)
    assert str(caught.value).startswith(f'read_plan: {named}')


@pytest.mark.parametrize(
    ('call', 'named'),
    [
        (lambda: fpnet.read_plan(None), 'read_plan: path: expected str or Path, got None'),
        (lambda: fpnet.read_robot_map(b'map.png'), 'read_robot_map: path'),
        (
            lambda: fpnet.segment(np.zeros((9, 9))),
            'segment: subject: expected Reading or RobotMap',
        ),
        (lambda: fpnet.match('plan.png', 7), 'match: robot_map'),
        (lambda: fpnet.match_site('site.yaml', 'map.png'), 'match_site: site: expected Site'),
        (lambda: fpnet.diff({}, 'map.png'), 'diff: plan'),
        (lambda: fpnet.read_site(['a', 'b']), 'read_site: path'),
        (lambda: fpnet.check_plan(1.5), 'check_plan: plan'),
        (lambda: fpnet.localize('p.png', 'bag', topics=[1]), 'localize: topics: expected str or'),
        (lambda: fpnet.localize('p.png', 'bag', odometry='wheels'), 'kiss, robot, both or None'),
        (lambda: fpnet.load_config(3), 'load_config: path'),
        (lambda: fpnet.load_config(None, {3: 4}), 'load_config: overrides: expected dict'),
        (lambda: fpnet.load_config(None, ['seed=3']), 'load_config: overrides: expected dict'),
    ],
)
def test_every_function_of_the_interface_names_what_is_wrong(call, named):
    with pytest.raises(fpnet.FpnetError) as caught:
        call()
    assert named in str(caught.value)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(
    'arguments',
    [
        {'resolution': 1},
        {'resolution': np.float32(0.05), 'storey': np.int64(2), 'page': None},
        {'crop': [0, 0, 20, 20]},
        {'length': [0, 0, 20.0, np.float64(0.0), 6.0], 'layers': ('A', 'B')},
        {'config': fpnet.FpnetConfig()},
    ],
)
def test_arguments_of_like_types_go_through(arguments):
    with pytest.raises(fpnet.FpnetError, match=NO_FILE):
        fpnet.read_plan(Path('no.png'), **arguments)


def test_what_the_system_refuses_is_named(tmp_path):
    endless = tmp_path / ('x' * 300)
    for read in (fpnet.read_robot_map, fpnet.read_site):
        with pytest.raises(fpnet.FpnetError, match=r'xxx: File name too long'):
            read(endless)


def test_pictures_are_drawn_on_what_matplotlib_draws_on(tmp_path):
    write_map(plan_grid(), tmp_path / 'plan.yaml')
    plan = fpnet.read_plan(tmp_path / 'plan.yaml')
    for value in (plan, fpnet.segment(plan)):
        with pytest.raises(fpnet.FpnetError, match=r"matplotlib axes to draw on, got 'x\.png'"):
            value.plot('x.png')


def test_too_few_and_unknown_arguments_are_pythons_own_errors():
    with pytest.raises(TypeError, match='path'):
        fpnet.read_plan()
    with pytest.raises(TypeError, match='resolutoin'):
        fpnet.read_plan('no.png', resolutoin=0.05)
