# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet library``: drawings in folders become a library, and it names a robot's building."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from fpnet.cli import build_app
from fpnet_core.errors import LibraryError
from fpnet_core.io.maps import write_map
from fpnet_lab.evaluation.localization.cases import Distortion
from fpnet_lab.evaluation.localization.plans import draw_plan
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.rough import robot_map_of
from fpnet_lab.sim.plans import generate_plan

FAMILIES = ('double_corridor', 'racetrack', 'branched', 'central_hall', 'bays', 'bent')
TRUE = 'branched'


def fpnet(*words):
    result = CliRunner().invoke(build_app(words[0]), [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Drawings of six buildings, one file that is none, and a robot's map of one of them."""
    folder = tmp_path_factory.mktemp('library')
    (folder / 'plans').mkdir()
    for number, family in enumerate(FAMILIES):
        rng = np.random.default_rng((77, number))
        plan = generate_plan(rng, family, 10, 30)
        drawn = draw_plan(plan, Distortion.STRETCHED_5, number)
        write_map(drawn.grid, folder / 'plans' / f'{family}.yaml')
        if family == TRUE:
            write_map(robot_map_of(render_plan(plan, 0.05), rng), folder / 'seen.yaml')
    (folder / 'plans' / 'broken.png').write_bytes(b'no picture')
    return folder


def test_a_library_is_built_and_names_the_building_that_was_seen(folder):
    built = fpnet('library', 'build', folder / 'plans', '--out', folder / 'lib')
    assert built.exit_code == 0
    assert 'broken.png' in built.stderr
    assert '6 of 7 floorplans' in built.stdout

    found = fpnet(
        'library', 'find', folder / 'lib', '--submap', folder / 'seen.yaml', '--search',
        '--json', '-',
    )  # fmt: skip
    assert found.exit_code == 0
    report = json.loads(found.stdout)
    assert report['plans'] == 6
    assert report['proposals'][0]['path'] == str(folder / 'plans' / f'{TRUE}.yaml')
    assert report['status'] == 'matched'
    assert report['path'] == str(folder / 'plans' / f'{TRUE}.yaml')


def test_what_belongs_to_none_of_them_is_not_claimed(folder, tmp_path):
    others = [folder / 'plans' / f'{family}.yaml' for family in FAMILIES if family != TRUE]
    fpnet('library', 'build', *others, '--out', tmp_path / 'lib')
    found = fpnet(
        'library', 'find', tmp_path / 'lib', '--submap', folder / 'seen.yaml', '--search',
        '--json', '-',
    )  # fmt: skip
    assert found.exit_code == 3
    assert json.loads(found.stdout)['status'] != 'matched'


def test_two_that_are_alike_leave_it_open(folder, tmp_path):
    for name in ('one', 'other'):
        for suffix in ('.yaml', '.png'):
            source = (folder / 'plans' / f'{TRUE}{suffix}').read_bytes()
            renamed = source.replace(f'{TRUE}.png'.encode(), f'{name}.png'.encode())
            (tmp_path / f'{name}{suffix}').write_bytes(renamed)
    fpnet('library', 'build', tmp_path / 'one.yaml', tmp_path / 'other.yaml', '--out', tmp_path)
    found = fpnet(
        'library', 'find', tmp_path, '--submap', folder / 'seen.yaml', '--search', '--json', '-'
    )
    assert json.loads(found.stdout)['status'] == 'ambiguous'
    assert found.exit_code == 3


def test_a_plan_that_has_gone_is_named(folder, tmp_path):
    lonely = tmp_path / 'gone.yaml'
    for suffix in ('.yaml', '.png'):
        source = folder / 'plans' / f'{TRUE}{suffix}'
        lonely.with_suffix(suffix).write_bytes(
            source.read_bytes().replace(f'{TRUE}.png'.encode(), b'gone.png')
        )
    fpnet('library', 'build', lonely, '--out', tmp_path / 'lib')
    lonely.unlink()
    with pytest.raises(LibraryError, match=r'gone\.yaml.*build the library again'):
        fpnet('library', 'find', tmp_path / 'lib', '--submap', folder / 'seen.yaml', '--search')
