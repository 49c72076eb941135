# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
``fpnet demo``: simulate a recording, run all nodes on it, evaluate the published poses.

The nodes run in a separate process (``python -m fpnet_lab.nodes.session``), which writes files for
the evaluation here: this module imports no ROS.
"""

from __future__ import annotations

from pathlib import Path
import shutil
import signal
import subprocess
import sys
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from fpnet.cli import INTERRUPTED, common
from fpnet.cli.progress import progress
from fpnet_core.errors import FpnetError
from fpnet_lab.cli.options import complete_sensor, named

if TYPE_CHECKING:
    from fpnet_core.config import FpnetConfig
    from fpnet_core.types import Segmentation
    from fpnet_lab.evaluation.demo import DemoRun

_SESSION_MODULE = 'fpnet_lab.nodes.session'
_GRACE_S = 30.0  # the session needs up to half of this to shut down its nodes; chosen


def command(
    out: Annotated[
        Path, typer.Option('--out', metavar='DIR', help='Folder for all output.')
    ] = Path('out/demo'),
    rate: Annotated[
        float, typer.Option('--rate', min=0.05, help='Recorded seconds per second.')
    ] = 1.0,
    sensor: Annotated[
        str,
        typer.Option(
            '--sensor',
            metavar='NAME',
            help='As in fpnet simulate recording.',
            autocompletion=complete_sensor,
        ),
    ] = 'beams32',
    laser_scans: Annotated[
        bool, typer.Option('--laser-scan', help='LaserScans instead of clouds; --sensor planar.')
    ] = False,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
) -> None:
    """
    Localize a simulated robot on a floorplan, with every node in its own process.

    Exits with 0 if the robot was localized and no wrong pose was published. Writes report.html,
    which plays the run and works offline, result.json, trajectory.png, the recording and all logs
    to the output folder, and replaces the previous demo.

    Example: fpnet demo --seed 3

    Example: fpnet demo --sensor planar --laser-scan
    """
    tree = common.load(config, settings, seed)
    recording, session = out / 'recording', out / 'session'
    for folder in (recording, session):
        shutil.rmtree(folder, ignore_errors=True)
    _simulate(recording, tree.seed, sensor, laser_scans)
    _run_session(recording, session, rate, tree)
    from fpnet_core.io.maps import read_map
    from fpnet_core.segmentation import segment_floorplan
    from fpnet_lab.evaluation.demo import rate_demo

    run = rate_demo(recording, session)
    common.write_json(out / 'result.json', {'seed': tree.seed, **run.as_json()})
    plan = segment_floorplan(read_map(recording / 'floorplan.yaml'), tree.segmentation)
    _draw(out / 'trajectory.png', session, run, plan)
    _report(out / common.REPORT_NAME, session, run, plan, tree.seed)
    typer.echo(f'seed {tree.seed}: {run.summary}; see {out / common.REPORT_NAME}')
    if not run.is_success:
        raise typer.Exit(1)


def _simulate(folder: Path, seed: int, sensor: str, laser_scans: bool) -> None:
    from fpnet_lab.sim.drives.recording import RecordingOptions, make_recording, write_recording
    from fpnet_lab.sim.lidars.sensors import SENSORS

    options = RecordingOptions(lidar=named('sensor', sensor, SENSORS))
    with progress('simulating a recording', total=1.0) as advance:
        write_recording(
            make_recording(seed, options),
            folder,
            laser_scans=laser_scans,
            progress=lambda _, total: advance(1.0 / total),
        )


def _run_session(recording: Path, session: Path, rate: float, config: FpnetConfig) -> None:
    """Run the nodes; raise FpnetError or typer.Exit if they did not finish the recording."""
    from fpnet_core.config_docs import render_yaml

    session.mkdir(parents=True)
    params_file = session / 'fpnet.yaml'
    params_file.write_text(render_yaml(config), encoding='utf-8')
    arguments = [recording / 'bag', recording / 'floorplan.yaml', session]
    options = ['--rate', rate, '--params-file', params_file]
    words = [sys.executable, '-m', _SESSION_MODULE, *map(str, arguments + options)]
    previous = signal.signal(signal.SIGTERM, _raise_interrupt)
    process = subprocess.Popen(words)  # noqa: S603 - this interpreter and our own arguments
    try:
        status = process.wait()
    except KeyboardInterrupt:
        status = INTERRUPTED
    finally:
        _end(process)
        signal.signal(signal.SIGTERM, previous)
    if status == INTERRUPTED:
        raise typer.Exit(INTERRUPTED)
    if status:
        raise FpnetError(f'the demo was not completed; see {session / "log"}')


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(timeout=_GRACE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _raise_interrupt(_signal: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def _draw(path: Path, session: Path, run: DemoRun, plan: Segmentation) -> None:
    from fpnet.viz.run import plot_run
    from fpnet_core.io.runs import read_output
    from fpnet_core.io.sessions import TICK_NAME

    truth = run.truth.mapped(run.A_plan_building)
    last = read_output(session / TICK_NAME)
    plot_run(path, plan, last, run.published, truth, title=str(run.summary))


def _report(path: Path, session: Path, run: DemoRun, plan: Segmentation, seed: int) -> None:
    from fpnet.report import RunRecord, write_run_report
    from fpnet_lab.evaluation.demo import read_ticks

    record = RunRecord(
        f'Demo, seed {seed}',
        f'A generated building, four processes: {run.summary}',
        plan,
        read_ticks(session),
        run.published,
        run.truth,
        run.A_plan_building,
        run.as_json(),
    )
    write_run_report(path, record)
