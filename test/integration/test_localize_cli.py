# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet localize`` from a bag of raw clouds to poses on the floorplan, through KISS-ICP."""

import csv
import json
import shlex
import subprocess
import sys

import numpy as np
from PIL import Image, ImageOps
import pytest
from short_recording import start_of_recording

from fpnet.accuracy import pose_errors
from fpnet.cli import main
from fpnet.recordings.trajectories import read_tum, write_tum
from fpnet_core.drawings.plan_files import as_json, record_path
from fpnet_core.drawings.read import read_plan
from fpnet_core.geometry import Affine2D
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_lab.sim.drives.recording import write_recording
from fpnet_lab.sim.lidars.sensors import LidarModel

pytestmark = pytest.mark.slow

# Fewer rays than the demo's lidar, so that odometry takes a fraction of the time.
COARSE = LidarModel(beams=16, columns=300)
DRIVE_S = 45.0


def run_cli(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    return ended.value.code or 0


def name_rooms(yaml_path):
    """Give each room of a map a name, in the record beside the map."""
    plan = read_plan(yaml_path)
    rooms = plan.segmentation
    cells = {room.id: np.argwhere(rooms.labels == room.id + 1) for room in rooms.rooms}
    names = [
        {'name': f'room {number}', 'xy': rooms.grid.rc_to_xy(inside[len(inside) // 2]).tolist()}
        for number, inside in cells.items()
    ]
    record_path(yaml_path).write_text(json.dumps(as_json(plan) | {'room_names': names}))


@pytest.fixture(scope='module')
def localized(tmp_path_factory):
    folder = tmp_path_factory.mktemp('localize')
    write_recording(start_of_recording(DRIVE_S, COARSE, 2), folder / 'drive', storage='mcap')
    truth = read_tum(folder / 'drive' / 'truth.tum')
    A_plan_building = Affine2D.from_matrix(
        json.loads((folder / 'drive' / 'truth.json').read_text())['A_plan_building']
    )
    path = PlanarTrajectory.from_transforms(truth.stamps_ns, truth.T_frame_body)
    on_plan = path.mapped(A_plan_building)
    write_tum(folder / 'on_plan.tum', on_plan.stamps_ns, on_plan.xy, on_plan.yaw)
    name_rooms(folder / 'drive' / 'floorplan.yaml')
    code = run_cli(
        'localize', folder / 'drive' / 'bag',
        '--floorplan', folder / 'drive' / 'floorplan.yaml',
        '--truth', folder / 'on_plan.tum',
        '--tum', folder / 'out.tum',
        '--rooms', folder / 'rooms.csv',
        '--json', folder / 'out.json',
    )  # fmt: skip
    assert code == 0
    return folder, json.loads((folder / 'out.json').read_text()), on_plan


LAB = (
    *('fpnet_lab', 'open3d', 'sklearn', 'lightning_fabric', 'tensorboardX', 'pygmtools'),
    *('matplotlib', 'plotly', 'jinja2', 'ezdxf', 'pypdfium2', 'svgelements', 'distributed'),
)
WITHOUT_LAB = f"""
import sys
sys.modules.update(dict.fromkeys({LAB!r}))  # None: cannot be imported
from fpnet.cli import main
main(sys.argv[1:])
"""


def run_without_lab(*arguments):
    words = [sys.executable, '-c', WITHOUT_LAB, *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True, check=False)


def test_a_robot_needs_no_library_of_the_lab(localized, tmp_path):
    folder, summary, _ = localized
    drive = folder / 'drive'
    words = ('--floorplan', drive / 'floorplan.yaml', '--set', 'localizer.update_period_s=5')
    done = run_without_lab('localize', drive / 'bag', *words, '--json', tmp_path / 'out.json')
    assert done.returncode == 0, done.stderr
    figures = json.loads((tmp_path / 'out.json').read_text())
    assert (figures['status'], figures['scans']) == (summary['status'], summary['scans'])


def test_what_a_report_needs_is_missed_before_the_run(localized, tmp_path):
    drive = localized[0] / 'drive'
    plan = ('--floorplan', drive / 'floorplan.yaml')
    done = run_without_lab('localize', drive / 'bag', *plan, '--out', tmp_path / 'run')
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].endswith("pip install 'fpnet_ros[report]'")
    assert not (tmp_path / 'run').exists()


def test_the_robot_is_found_and_no_pose_is_wrong(localized):
    _, summary, _ = localized
    assert summary['localized']
    assert summary['wrong_poses'] == 0
    assert summary['median_position_error_m'] < 0.5
    assert summary['nees_mean'] < 8.0
    assert summary['sigma_position_m_median'] > 0.02
    assert summary['rejected_scans'] == 0
    assert ' m of observed wall; ' in summary['reason']
    assert 0.0 < summary['path_to_first_pose_m'] < summary['path_m']


def test_the_rooms_written_are_those_that_the_robot_was_in(localized):
    folder, summary, truth = localized
    with (folder / 'rooms.csv').open(encoding='utf-8') as file:
        stays = list(csv.DictReader(file))
    rooms = read_plan(folder / 'drive' / 'floorplan.yaml').segmentation
    rows, cols = np.round(rooms.grid.xy_to_rc(truth.xy)).astype(int).T
    label = rooms.labels[rows, cols]
    assert stays
    for stay in stays:
        within = (truth.stamps_ns >= float(stay['entered_s']) * 1e9 - 1e6) & (
            truth.stamps_ns <= float(stay['left_s']) * 1e9 + 1e6
        )
        true = label[within]
        assert np.mean(true[true > 0] == int(stay['room'].removeprefix('room ')) + 1) > 0.9
    last = read_tum(folder / 'out.tum').T_frame_body[-1, :2, 3]
    row, col = np.round(rooms.grid.xy_to_rc(last)).astype(int)
    under = rooms.labels[row, col]
    assert summary['room'] == (f'room {under - 1}' if under else None)


def test_the_poses_written_are_those_that_were_judged(localized):
    folder, summary, on_plan = localized
    poses = read_tum(folder / 'out.tum')
    assert len(poses) == summary['poses']
    written = PlanarTrajectory.from_transforms(poses.stamps_ns, poses.T_frame_body)
    position, _ = pose_errors(written, on_plan)
    assert np.median(position) == pytest.approx(summary['median_position_error_m'], abs=1e-3)


def test_a_drawing_without_a_scale_is_searched_and_a_mirrored_one_is_named(
    localized, tmp_path, capsys
):
    """The floorplan as a bare image, flipped: what is printed names the cause and what to type."""
    folder, _, _ = localized
    image = tmp_path / 'flipped.png'
    with Image.open(folder / 'drive' / 'floorplan.png') as drawn:
        ImageOps.mirror(drawn.convert('L').point(lambda grey: 255 if grey > 250 else 0)).save(
            image
        )
    bag = folder / 'drive' / 'bag'
    poses = folder / 'drive' / 'truth.tum'
    out = tmp_path / 'out'
    options = ('--poses', poses, '--set', 'localizer.update_period_s=10')
    assert run_cli('localize', bag, '--floorplan', image, *options, '--out', out) == 3
    printed = capsys.readouterr().out
    report = json.loads((out / 'run.json').read_text())
    assert not report['localized']
    cause = report['causes'][0]
    assert cause['cause'] == 'floorplan mirrored'
    command = f'fpnet localize {bag} --set localizer.update_period_s=10 --poses {poses}'
    command += f' --floorplan {image} --mirrored'
    assert cause['next'] == command
    assert f'1. floorplan mirrored: {cause["evidence"]}\n   next: {command}' in printed
    assert 'Likely causes' in (out / 'report.html').read_text(encoding='utf-8')
    assert run_cli(*shlex.split(command)[1:], '--json', tmp_path / 'flipped.json') == 0
    flipped = json.loads((tmp_path / 'flipped.json').read_text())
    assert flipped['localized']
    assert flipped['causes'] == []


def test_bad_recordings_end_in_one_line(localized, tmp_path, capsys):
    folder, _, _ = localized
    plan = folder / 'drive' / 'floorplan.yaml'
    corrupt = tmp_path / 'corrupt.mcap'
    bag = next((folder / 'drive' / 'bag').glob('*.mcap'))
    corrupt.write_bytes(bag.read_bytes()[:20_000])
    text = tmp_path / 'notes.txt'
    text.write_text('no recording')
    for recording in (tmp_path / 'missing', corrupt, text):
        assert run_cli('localize', recording, '--floorplan', plan) == 1
        error = capsys.readouterr().err
        assert error.startswith('fpnet: '), recording
        assert error.count('\n') == 1, error


def test_bad_weights_end_in_one_line(localized, tmp_path, capsys):
    folder, _, _ = localized
    weights = tmp_path / 'bad.safetensors'
    weights.write_bytes(b'not tensors')
    weights.with_suffix('.json').write_text('{}')
    code = run_cli(
        'localize', folder / 'drive' / 'bag',
        '--floorplan', folder / 'drive' / 'floorplan.yaml',
        '--set', f'matcher.weights={weights}',
    )  # fmt: skip
    assert code == 1
    assert capsys.readouterr().err.count('\n') == 1
