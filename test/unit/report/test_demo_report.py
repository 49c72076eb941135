# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet demo`` from the files that simulation and nodes leave to its pictures and report."""

import json

import pytest

from fpnet.cli import main
from fpnet.recordings.trajectories import write_tum
from fpnet_core.io.maps import write_map
from fpnet_core.io.runs import write_output
from fpnet_lab.cli import demo


@pytest.fixture
def without_nodes(made_up_run, monkeypatch):
    """Let the made-up run be what was simulated and localised."""
    run = made_up_run

    def simulate(folder, seed, sensor, laser_scans):
        assert (seed, laser_scans) == (5, False)
        write_map(run.plan.grid, folder / 'floorplan.yaml')
        write_tum(folder / 'truth.tum', run.truth.stamps_ns, run.truth.xy, run.truth.yaw)
        matrix = run.A_plan_truth.matrix[:2].tolist()
        (folder / 'truth.json').write_text(json.dumps({'A_plan_building': matrix}))

    def run_session(recording, session, rate, config):
        assert (recording / 'floorplan.yaml').exists()
        for output in run.outputs:
            write_output(session / 'ticks' / f'{output.stamp_ns:020d}.npz', output)
        write_output(session / 'last_tick.npz', run.outputs[-1])
        published = run.published
        write_tum(session / 'poses.tum', published.stamps_ns, published.xy, published.yaw)
        updates = [{'status': output.status.value} for output in run.outputs]
        facts = {'scans': 2, 'registered_scans': 2, 'ticks': updates}
        (session / 'session.json').write_text(json.dumps(facts))

    monkeypatch.setattr(demo, '_simulate', simulate)
    monkeypatch.setattr(demo, '_run_session', run_session)


def test_the_demo_leaves_a_report_of_its_ticks(without_nodes, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(['demo', '--out', str(tmp_path / 'demo'), '--seed', '5'])
    assert not ended.value.code
    assert 'see ' + str(tmp_path / 'demo' / 'report.html') in capsys.readouterr().out
    text = (tmp_path / 'demo' / 'report.html').read_text(encoding='utf-8')
    assert 'id="slider" type="range" min="0" max="1"' in text  # one tick had no submap
    assert 'Demo, seed 5' in text
    assert json.loads((tmp_path / 'demo' / 'result.json').read_text())['wrong_poses'] == 0
    assert (tmp_path / 'demo' / 'trajectory.png').stat().st_size > 10_000
