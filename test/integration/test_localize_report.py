# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet localize`` on raw scans with KISS-ICP's poses, and all that ``--out`` gets."""

import json

import numpy as np
from PIL import Image
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import drive, recorded, standing
import pytest

from fpnet.cli import main
from fpnet.recordings.trajectories import write_tum
from fpnet_core.io.maps import read_map, write_map

pytestmark = pytest.mark.slow


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Scans as files, poses as KISS-ICP numbers them, the truth as a simulation writes it."""
    folder = tmp_path_factory.mktemp('localize')
    scans = folder / 'scans'
    scans.mkdir()
    for index, (points, _, _) in enumerate(recorded()):
        np.save(scans / f'{index:06d}.npy', points)
    poses = np.array([T_odom_sensor for _, T_odom_sensor, _ in recorded()])
    np.save(folder / 'drive_poses.npy', poses)
    write_map(plan_grid(), folder / 'plan.yaml')
    truth = np.array(drive())
    # A folder without times: its scans are a tenth of a second apart.
    stamps = np.arange(len(truth)) * 100_000_000
    write_tum(folder / 'sim' / 'truth.tum', stamps, truth[:, :2], truth[:, 2])
    matrix = A_BUILDING_PLAN.inv().matrix[:2].tolist()
    (folder / 'sim' / 'truth.json').write_text(json.dumps({'A_plan_building': matrix}))
    return folder


def test_a_folder_with_kiss_icp_poses_ends_in_a_report(folder, capsys):
    out = folder / 'run'
    with pytest.raises(SystemExit) as ended:
        main([
            'localize', str(folder / 'scans'), '--floorplan', str(folder / 'plan.yaml'),
            '--poses', str(folder / 'drive_poses.npy'), '--out', str(out), '--json', '-',
            '--truth', str(folder / 'sim' / 'truth.tum'),
            '--set', 'localizer.max_speed_mps=50',
        ])  # fmt: skip
    assert not ended.value.code
    figures = json.loads(capsys.readouterr().out)
    assert figures['status'] == 'localized'
    assert figures['wrong_poses'] == 0
    assert figures['median_position_error_m'] < 0.2
    assert 0.0 < figures['nees_mean'] < 8.0
    assert 0.02 < figures['sigma_position_m_median'] < 0.5
    assert json.loads((out / 'run.json').read_text()) == figures
    assert {path.name for path in out.iterdir()} == {
        *('report.html', 'run.json', 'poses.tum', 'covariances.csv', 'odometry.tum', 'run.mcap'),
        *('map.yaml', 'map.png', 'submap.yaml', 'submap.png'),
        *('differences.geojson', 'differences.png'),
    }
    assert read_map(out / 'submap.yaml').resolution == 0.05
    text = (out / 'report.html').read_text(encoding='utf-8')
    assert 'scans on plan.yaml' in text
    assert '<dt>error, median</dt>' in text
    assert '<h1>plan</h1>' in text
    with pytest.raises(SystemExit) as ended:
        main(['view', str(out), '--poster', str(out / 'poster.png')])
    assert not ended.value.code
    assert min(Image.open(out / 'poster.png').size) > 500


def test_a_recording_that_stands_still_ends_in_a_report(folder, tmp_path, capsys):
    scans, out = tmp_path / 'scans', tmp_path / 'run'
    scans.mkdir()
    for index, (points, _, _) in enumerate(standing(60)):
        np.save(scans / f'{index:06d}.npy', points)
    np.save(tmp_path / 'poses.npy', np.tile(np.eye(4), (60, 1, 1)))
    with pytest.raises(SystemExit) as ended:
        main(
            [
                'localize', str(scans), '--poses', str(tmp_path / 'poses.npy'),
                '--floorplan', str(folder / 'plan.yaml'), '--out', str(out),
            ]
        )  # fmt: skip
    assert ended.value.code == 3
    assert (
        '1. too little observed: the robot stood still (0.0 m driven)' in capsys.readouterr().out
    )
    assert {'report.html', 'run.json', 'odometry.tum'} <= {path.name for path in out.iterdir()}
