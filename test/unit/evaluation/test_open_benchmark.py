# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench open`` from the outside: any program is run on cases and scored."""

import hashlib
import json
from pathlib import Path
import re
import runpy
import sys

import numpy as np
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import SCAN_NS, drive, scan
import pytest

from fpnet.cli import main
from fpnet.recordings.opening import open_scans
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.io.maps import read_map, write_map
from fpnet_core.io.scans import Scan
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import OCCUPIED
from fpnet_lab.evaluation.open_benchmark.protocol import CaseSet, InputIs, PlanIs
from fpnet_lab.evaluation.open_benchmark.writing import (
    BenchmarkBuilding,
    DrawnSheet,
    drive_inputs,
    write_cases,
)
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.plans import generate_plan

FETCH = Path(__file__).resolve().parents[3] / 'benchmarks' / 'fetch_open_data.py'

PAGE = Path(__file__).resolve().parents[3] / 'docs' / 'open_benchmark.md'
[EXAMPLE] = re.findall(r'^```python\n(.*?)^```', PAGE.read_text('utf-8'), re.DOTALL | re.MULTILINE)

CANNOT_SAY = """
import sys

plan, scans, out = sys.argv[1:]
with open(out, 'w') as answer:
    answer.write('cannot say')
"""

ALWAYS = """
import sys

plan, scans, out = sys.argv[1:]
with open(out, 'w') as answer:
    for line in open(f'{scans}/odometry.tum'):
        answer.write(line)
"""


def call(*words):
    with pytest.raises(SystemExit) as ended:
        main(['bench', 'open', *map(str, words)])
    return ended.value.code or 0


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Cases of one building whose odometry knows nothing of it."""
    folder = tmp_path_factory.mktemp('open') / 'cases'
    rng, poses = np.random.default_rng(0), [SE2.from_xy_yaw(*each) for each in drive(step_m=0.3)]
    scans = [
        Scan(
            (k + 1) * SCAN_NS,
            scan(pose.translation, pose.yaw, rng),
            T_odom_sensor=(poses[0].inv() @ pose).as_matrix4(),
        )
        for k, pose in enumerate(poses)
    ]
    truth = PlanarTrajectory.of([(each.stamp_ns, T) for each, T in zip(scans, poses, strict=True)])
    plan = plan_grid()
    foreign = render_plan(generate_plan(np.random.default_rng(5), 'bays'), 0.05)
    elsewhere = {
        PlanIs.FOREIGN: DrawnSheet(foreign),
        PlanIs.MIRRORED: DrawnSheet(plan.mirrored()),
    }
    inputs = drive_inputs(scans)
    building = BenchmarkBuilding(inputs, truth, DrawnSheet(plan), A_BUILDING_PLAN.inv(), elsewhere)
    write_cases(folder, iter([building]), {'track': 'planted', 'seed': 0}, 0)
    return folder


def ran(folder, tmp_path, source, *words):
    """Return the scores of a program of a few lines."""
    program = tmp_path / 'program.py'
    program.write_text(source)
    results, report = tmp_path / 'results', tmp_path / 'open.json'
    command = f'mine={sys.executable} {program}'
    assert call('run', '--cases', folder, '--program', command, '--out', results, *words) == 0
    assert call('score', '--cases', folder, '--results', results, '--json', report) == 0
    return json.loads(report.read_text())['programs']['mine']


def answering(folder, of_case):
    """Return a program that looks up its answers by plan and scans: what no program can do."""
    cases = CaseSet.read(folder)
    lines = {}
    for case in cases.cases:
        stated = of_case(cases, case)
        half = 0.5 * stated.yaw
        lines[f'{Path(case.plan).name} {Path(case.scans).name}'] = [
            f'{ns * 1e-9:.9f} {x} {y} 0 0 0 {qz} {qw} localized 0.9'
            for ns, (x, y), qz, qw in zip(
                stated.stamps_ns, stated.xy, np.sin(half), np.cos(half), strict=True
            )
        ]
    return f"""
import sys
from pathlib import Path

plan, scans, out = map(Path, sys.argv[1:])
out.write_text('\\n'.join({lines!r}[plan.name + ' ' + scans.name]))
"""


def on_the_own_plan(cases, case):
    """Return the true poses of a case's scans on the plan of their building."""
    odometry, true = cases.odometry(case), cases.true_poses(case)
    poses, _ = true.at(odometry.stamps_ns)
    return poses.mapped(A_BUILDING_PLAN.inv())


def test_a_newcomers_program_that_cannot_say_is_never_right_nor_wrong(folder, tmp_path):
    scores = ran(folder, tmp_path, CANNOT_SAY)
    assert scores['drive'] == 1
    assert scores['drive_right'] == scores['drive_claimed_wrong'] == scores['failed'] == 0
    assert scores['foreign_claimed'] == scores['mirrored_claimed'] == 0
    assert (scores['first_pose_m'], scores['ece'], scores['challenge']) == (None, None, 0.0)


def test_the_pages_example_is_a_program(folder, tmp_path):
    scores = ran(folder, tmp_path, EXAMPLE)
    assert scores['failed'] == scores['drive_right'] == 0
    row = "[(0, *frame['origin'], 'localized', 0.7)]"
    scores = ran(folder, tmp_path, EXAMPLE.replace('return []', f'return {row}'))
    assert scores['failed'] == 0
    assert (scores['drive_claimed_wrong'], scores['map_claimed_wrong']) == (1, 1)
    assert (scores['first_pose_m'], scores['ece']) == (0.0, pytest.approx(0.7))


def test_the_truth_is_right_and_its_claims_on_other_plans_are_counted(folder, tmp_path):
    scores = ran(folder, tmp_path, answering(folder, on_the_own_plan))
    assert (scores['drive_right'], scores['drive_claimed_right']) == (1, 1)
    assert (scores['successes'], scores['sequences']) == (1, 1)
    assert scores['challenge'] == pytest.approx(100.0, abs=0.1)
    assert scores['position_m'] < 1e-3
    assert scores['first_pose_m'] == scores['first_pose_s'] == 0.0
    for each in list(InputIs)[1:]:
        assert scores[each.value] == scores[f'{each.value}_right'] == 1, each
    assert (scores['foreign_claimed'], scores['mirrored_claimed']) == (1, 1)
    cases = CaseSet.read(folder)
    lines = {case: len(cases.odometry(case)) for case in cases.cases}
    own = sum(count for case, count in lines.items() if cases.A_plan_truth(case) is not None)
    right = own / sum(lines.values())
    assert scores['ece'] == pytest.approx(0.9 - right, abs=1e-4), '0.9 is stated of all poses'
    assert scores['brier'] == pytest.approx(0.81 - 0.8 * right, abs=1e-4)


def test_the_truth_of_another_building_is_wrong(folder, tmp_path):
    def elsewhere(cases, case):
        return on_the_own_plan(cases, case).mapped(Affine2D(np.eye(2), np.array([9.0, 4.0])))

    scores = ran(folder, tmp_path, answering(folder, elsewhere))
    assert (scores['drive_right'], scores['drive_claimed_wrong']) == (0, 1)
    assert scores['successes'] == 0
    # exp(-0.4605 * 9.85): an error of 9.85 m is worth one point.
    assert scores['challenge'] == pytest.approx(100.0 * np.exp(-0.4605 * np.hypot(9, 4)), rel=1e-3)
    assert scores['position_m'] == pytest.approx(np.hypot(9, 4), rel=1e-3)
    assert all(scores[f'{each.value}_right'] == 0 for each in InputIs)


def test_a_command_without_a_name_has_that_of_its_file(folder, tmp_path, capsys):
    (tmp_path / 'mine.py').write_text(CANNOT_SAY)
    command = f'{sys.executable} {tmp_path / "mine.py"} {{plan}} {{scans}} {{out}}'
    assert call('run', '--cases', folder, '--program', command, '--out', tmp_path / 'out') == 0
    assert (tmp_path / 'out' / 'mine' / 'run.json').exists()
    assert call('run', '--cases', folder, '--program', 'fpnt', '--out', tmp_path / 'out') == 1
    assert "unknown program 'fpnt'; choose one of fpnet, " in capsys.readouterr().err


def test_plain_lines_claim_with_probability_one(folder, tmp_path):
    scores = ran(folder, tmp_path, ALWAYS)  # odometry, in a frame of its own
    assert scores['drive_claimed_wrong'] == 1
    assert scores['brier'] > 0.9


@pytest.mark.parametrize(
    ('line', 'said'),
    [
        ('0.2 1 2', 'pose line 1 has 3 values; expected'),
        ('0.2 1 2 0 0 0 0 1 localized 1.5', "probability '1.5'; expected a number from 0 to 1"),
        ('7777 1 2 0 0 0 0 1', 'pose line 1 is not at the time of a scan'),
        ('0.2 1 2 0 0 0 0 nan', 'NaN'),
        (None, 'it ended with 1: NameError'),
    ],
)
def test_a_malformed_answer_counts_as_cannot_say_and_is_named(
    folder, tmp_path, capsys, line, said
):
    source = 'unknown' if line is None else f'import sys\nopen(sys.argv[3], "w").write({line!r})'
    scores = ran(folder, tmp_path, source)
    assert said in capsys.readouterr().out
    assert scores['failed'] == len(CaseSet.read(folder).cases)
    assert scores['drive_claimed_wrong'] == 0


def test_results_of_other_cases_are_refused(folder, tmp_path, capsys):
    ran(folder, tmp_path, CANNOT_SAY)
    path = tmp_path / 'results' / 'mine' / 'run.json'
    path.write_text(path.read_text().replace('"cases_sha256": "', '"cases_sha256": "0'))
    code = call('score', '--cases', folder, '--results', tmp_path / 'results')
    assert code == 1
    assert 'has results of other cases than' in capsys.readouterr().err


@pytest.mark.slow
def test_own_programs_answer_the_same_twice_and_stand_side_by_side(folder, tmp_path):
    names = ('fpnet', 'matcher_ransac', 'monte_carlo')
    words = [word for name in names for word in ('--program', name)]
    answers = []
    for attempt in ('first', 'second'):
        out = tmp_path / attempt
        assert call('run', '--cases', folder, '--out', out, *words) == 0
        files = sorted(out.glob('*/answers/*.tum'))
        answers.append({path.relative_to(out): path.read_bytes() for path in files})
    assert len(answers[0]) == len(names) * len(CaseSet.read(folder).cases)
    assert answers[0] == answers[1]
    tables, report = tmp_path / 'tables.md', tmp_path / 'open.json'
    words = ('--results', tmp_path / 'first', '--markdown', tables, '--json', report)
    assert call('score', '--cases', folder, *words) == 0
    assert tables.read_text().count('| `fpnet` |') == 2
    ours = json.loads(report.read_text())['programs']['fpnet']
    assert (ours['drive_right'], ours['drive_claimed_right'], ours['map_right']) == (1, 1, 1)
    assert ours['foreign_claimed'] == ours['mirrored_claimed'] == ours['failed'] == 0


def walls_at(cases, case):
    """Return the share of a drive's returns within 0.3 m of a dark cell, placed by the truth."""
    A, true = cases.A_plan_truth(case), cases.true_poses(case)
    plan = cases.folder / case.plan
    grid = read_map(plan.with_suffix('.yaml'))
    wall = np.argwhere(grid.cells == OCCUPIED)
    marked = np.zeros(grid.shape, dtype=bool)
    marked[tuple(wall.T)] = True
    reach = int(np.ceil(0.3 / grid.resolution))
    hits = []
    for each in list(open_scans(cases.folder / case.scans))[::20]:
        pose, _ = true.at(np.array([each.stamp_ns]))
        T = SE2.from_xy_yaw(*pose.xy[0], float(pose.yaw[0]))
        rc = np.rint(grid.xy_to_rc((A @ T).apply(each.points[:, :2].astype(float)))).astype(int)
        rc = rc[((rc >= reach) & (rc < np.array(grid.shape) - reach)).all(axis=1)]
        hits += [marked[r - reach : r + reach + 1, c - reach : c + reach + 1].any() for r, c in rc]
    return float(np.mean(hits))


@pytest.mark.slow
@pytest.mark.parametrize('track', ['exact', 'sheets'])
def test_generated_cases_hold_scans_whose_truth_is_on_the_walls(tmp_path, track):
    folder = tmp_path / 'cases'
    assert call('make', '--track', track, '--count', '1', '--seed', '4', '--out', folder) == 0
    cases = CaseSet.read(folder)
    kinds = [
        (cases.truths[case.name].plan_is, cases.truths[case.name].input_is) for case in cases.cases
    ]
    wrong = set(PlanIs) - {PlanIs.OWN} - ({PlanIs.OTHER_FLOOR} if track == 'sheets' else set())
    assert sorted(kinds) == sorted(
        [(PlanIs.OWN, each) for each in InputIs] + [(each, InputIs.DRIVE) for each in wrong]
    )
    [own] = [
        c
        for c, kind in zip(cases.cases, kinds, strict=True)
        if kind == (PlanIs.OWN, InputIs.DRIVE)
    ]
    assert walls_at(cases, own) > 0.6  # the rest is furniture
    assert call('make', '--track', track, '--count', '1', '--out', folder) == 1, 'kept'


@pytest.fixture
def public(tmp_path):
    """Files of a real building on a web server that is a folder, and their manifest."""
    server = tmp_path / 'server'
    plan = plan_grid()
    write_map(plan, server / 'plan.yaml')
    write_map(plan, server / 'map.yaml')
    size = plan.shape[0]
    A_pixel_map = [[20.0, 0.0, -0.5], [0.0, -20.0, size - 0.5]]  # 0.05 m per pixel, both alike
    files = {
        name: {
            'url': (server / name).as_uri(),
            'sha256': hashlib.sha256((server / name).read_bytes()).hexdigest(),
            'licence': 'CC0',
        }
        for name in ('plan.png', 'map.png')
    }
    entry = {'name': 'planted', 'input': 'map', 'scans': 'map.png', 'plan': 'plan.png'}
    manifest = tmp_path / 'manifest.json'
    content = {
        'format': 'fpnet_open_real_1',
        'files': files,
        'entries': [{**entry, 'A_pixel_scans': A_pixel_map}],
    }
    manifest.write_text(json.dumps(content))
    return manifest


def test_public_files_are_named_when_missing_and_fetched_by_a_script_only(
    public, tmp_path, capsys, monkeypatch
):
    data, folder = tmp_path / 'data', tmp_path / 'cases'
    words = ('--track', 'real', '--manifest', public, '--data', data, '--out', folder)
    assert call('make', *words) == 1
    said = capsys.readouterr()
    assert f'plan.png is missing: {(tmp_path / "server" / "plan.png").as_uri()} (CC0)' in said.out
    assert 'fetch_open_data.py' in said.err
    assert not data.exists()
    monkeypatch.setattr(sys, 'argv', ['fetch', '--out', str(data), '--manifest', str(public)])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(FETCH), run_name='__main__')
    assert not ended.value.code
    assert call('make', *words) == 0
    cases = CaseSet.read(folder)
    assert sorted(truth.plan_is for truth in cases.truths.values()) == ['mirrored', 'own']
    [own] = [case for case in cases.cases if cases.A_plan_truth(case) is not None]
    placed = cases.odometry(own).mapped(cases.A_plan_truth(own))
    assert placed.xy == pytest.approx(cases.odometry(own).xy, abs=1e-6)
    (data / 'plan.png').write_bytes(b'changed')
    again = (*words[:-1], tmp_path / 'again')
    assert call('make', *again) == 1
    assert 'is another file than' in capsys.readouterr().out
