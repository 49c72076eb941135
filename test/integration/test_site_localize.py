# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet localize --site`` on a generated site of two storeys, and what else takes a site."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner
import yaml

from fpnet.cli import build_app
from fpnet.recordings.trajectories import write_tum
from fpnet_core.io.maps import write_map
from fpnet_lab.evaluation.localization.inputs import LIMITS
from fpnet_lab.sim.drawn.storeys import Likeness, draw_storeys
from fpnet_lab.sim.drives.recording import RecordingOptions, make_recording, write_recording
from fpnet_lab.sim.lidars.sensors import SENSORS

pytestmark = pytest.mark.slow

SEED = 3
OPTIONS = RecordingOptions(
    family='double_corridor', rooms=(8, 60), limits=LIMITS, lidar=SENSORS['planar']
)


def fpnet(*words):
    result = CliRunner().invoke(build_app(words[0]), [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """A recording with true odometry, and a site whose second storey it is on."""
    folder = tmp_path_factory.mktemp('site')
    recording = make_recording(SEED, OPTIONS, threads=1)
    likenesses = (Likeness.ALIKE, Likeness.TRUE)
    storeys = draw_storeys(recording.building.plan, likenesses, np.random.default_rng(SEED))
    for storey in storeys:
        write_map(storey.drawn.grid, folder / f'{storey.name}.yaml')
    told = [{'name': s.name, 'plan': f'{s.name}.yaml', 'level': k} for k, s in enumerate(storeys)]
    (folder / 'site.yaml').write_text(yaml.safe_dump({'storeys': told}), encoding='utf-8')
    write_recording(recording, folder / 'drive', with_wheels=True, laser_scans=True)
    poses = recording.truth()
    yaw = np.arctan2(poses[:, 1, 0], poses[:, 0, 0])
    write_tum(folder / 'truth.tum', recording.stamps_ns, poses[:, :2, 3], yaw)
    return folder


def test_a_drive_is_localised_on_its_storey(folder):
    result = fpnet(
        'localize', folder / 'drive' / 'bag', '--site', folder / 'site.yaml', '--poses',
        folder / 'truth.tum', '--json', folder / 'run.json', '--out', folder / 'run',
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    report = json.loads((folder / 'run.json').read_text())
    assert report['status'] == 'localized'
    assert report['storey'] == 'L1'
    assert report['storeys']['L1'] > 0.9 > report['storeys']['L0']
    assert [claim['storey'] for claim in report['claims']] == ['L1']
    assert 'storey L1: ' in result.output
    assert (folder / 'run' / 'report.html').is_file()
    assert report['poses'] > 0
    assert (folder / 'run' / 'differences.png').is_file()
    found = json.loads((folder / 'run' / 'differences.geojson').read_text())
    assert found['type'] == 'FeatureCollection'


def test_what_was_seen_is_matched_and_compared_on_its_storey(folder):
    seen = folder / 'run' / 'submap.yaml'
    result = fpnet(
        'match', '--site', folder / 'site.yaml', '--submap', seen, '--json', folder / 'm.json'
    )
    assert result.exit_code == 0, result.output
    match = json.loads((folder / 'm.json').read_text())
    assert (match['status'], match['storey']) == ('matched', 'L1')
    assert list(match['storeys']) == ['L1', 'L0']
    result = fpnet(
        'diff', seen, '--site', folder / 'site.yaml', '--out', folder / 'diff', '--json',
        folder / 'd.json',
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    assert json.loads((folder / 'd.json').read_text())['storey'] == 'L1'
    assert (folder / 'diff' / 'differences.geojson').is_file()
    assert (folder / 'diff' / 'differences.png').stat().st_size > 1000


def test_nothing_is_said_of_a_drawing_on_which_nothing_was_placed(folder, tmp_path):
    """A storey without the rooms that were seen: lost, and not out of date."""
    from planted import plan_grid

    write_map(plan_grid(), tmp_path / 'other.yaml')
    result = fpnet(
        'diff', folder / 'run' / 'submap.yaml', '--floorplan', tmp_path / 'other.yaml', '--json',
        tmp_path / 'd.json',
    )  # fmt: skip
    assert result.exit_code == 3, result.output
    report = json.loads((tmp_path / 'd.json').read_text())
    assert report['status'] == 'lost'
    assert 'differences' not in report


def test_site_check_says_what_looks_alike(folder):
    result = fpnet('site', 'check', folder / 'site.yaml', '--json', folder / 'c.json')
    assert result.exit_code == 0, result.output
    check = json.loads((folder / 'c.json').read_text())
    assert [storey['name'] for storey in check['storeys']] == ['L0', 'L1']
    assert all(storey['rooms'] > 5 for storey in check['storeys'])
    pairs = {(each['storey'], each['other']): each for each in check['alike']}
    assert set(pairs) == {('L0', 'L1'), ('L1', 'L0')}
    for each in pairs.values():
        assert 0.7 < each['common_walls'] < 0.97
        assert each['differing_rooms']
        assert each['confusion'] < 0.5


@pytest.mark.parametrize(
    ('words', 'named'),
    [
        ((), 'give either --floorplan or --site'),
        (('--site', 'SITE', '--floorplan', 'SITE'), 'give either --floorplan or --site'),
        (('--site', 'SITE', '--resolution', '0.1'), '--resolution applies to one drawing'),
    ],
)
def test_one_of_both_is_named(folder, words, named):
    typed = [str(folder / 'site.yaml') if word == 'SITE' else word for word in words]
    with pytest.raises(Exception, match=named):
        fpnet('localize', folder / 'drive' / 'bag', *typed)
