# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet view``: show a run live, or replay a recorded one, in a browser on this machine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
import threading
import time
from typing import TYPE_CHECKING, Annotated

import typer

from fpnet.cli import common
from fpnet_core.errors import ConfigError
from fpnet_core.stamps import NS_PER_S

if TYPE_CHECKING:
    from fpnet.api.run import Run
    from fpnet.report.live import LiveRun
    from fpnet_core.config import FpnetConfig
    from fpnet_core.drawings.types import Reading

_Input = Annotated[
    Path,
    typer.Argument(
        metavar='INPUT',
        help='Recording, as for fpnet localize, or a folder written by its --out.',
    ),
]
_RateOption = Annotated[
    float,
    typer.Option('--rate', min=0.0, help='Recorded seconds per second; 0: as fast as possible.'),
]
_PosterOption = Annotated[
    Path | None,
    typer.Option(
        '--poster',
        metavar='OUT',
        help='Write the run of a folder as one picture (.png, .svg or .pdf) and exit.',
    ),
]
_EndOption = Annotated[
    bool, typer.Option('--end', help='Exit when the run ends; default: wait for Ctrl-C.')
]


@common.reads_drawing
def command(
    said: common.DrawingOptions,
    source: _Input,
    floorplan: common.FloorplanOption = None,
    rate: _RateOption = 1.0,
    port: common.PortOption = common.DEFAULT_PORT,
    end: _EndOption = False,
    poster: _PosterOption = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
) -> None:
    """
    Show a run live, or replay a recorded one, in a browser.

    The page shows the floorplan, the growing submap, the best placements, the status with its
    reason, and everything else in a report. It is served on 127.0.0.1, for this machine only, and
    loads nothing from the network. RViz and Foxglove show a running node (docs/ros.md).

    Example: fpnet view drive/bag --floorplan drive/floorplan.yaml

    Example: fpnet view out/run --rate 4

    Example: fpnet view out/run --poster poster.png
    """
    report = common.check_input(source) / common.REPORT_NAME
    if poster is not None:
        from fpnet.report.poster import write_poster

        write_poster(poster, report)
        return
    if report.is_file():
        _show_again(report, port, rate, end)
        return
    if floorplan is None:
        raise ConfigError(
            f'{source} has no {common.REPORT_NAME}; give the folder of a run, or a recording '
            'with --floorplan'
        )
    tree = common.load(config, settings, seed)
    reading = said.read(floorplan, tree)
    common.say_reading(reading, None)
    with _recording_on(source, reading, tree, port) as (run, live):
        follow(run, live, rate)
        _stay(end)


@contextmanager
def _recording_on(
    source: Path, reading: Reading, tree: FpnetConfig, port: int
) -> Iterator[tuple[Run, LiveRun]]:
    """Yield a run of a recording and its live page."""
    from fpnet.api.run import Run, scans_of
    from fpnet.report.live import LiveRun
    from fpnet_core.drawings.scaling import with_scale_of

    scans = scans_of(source, scan_stamp=tree.scans.stamp)
    run = Run(reading, scans, with_scale_of(reading, tree))
    with LiveRun(f'{source.name} on {reading.drawing.name}', run.rooms, port) as live:
        yield run, live


def follow(run: Run, live: LiveRun, rate: float = 0.0) -> None:
    """Run to the end and show each update; ``rate`` in recorded seconds per second."""
    from fpnet.report import RunRecord

    typer.echo(f'watch it at {live.url}', err=True)
    pace = _Pace(rate)
    for output in run:
        pace.wait_for(output.stamp_ns / NS_PER_S)
        known = run.so_far
        live.show(
            RunRecord('', '', run.rooms, known.outputs, known.published, odometry=known.odometry)
        )
    live.end(f'ended: {run.last.said}')


def _show_again(report: Path, port: int, rate: float, end: bool) -> None:
    from fpnet.report.live import RecordedRun

    with RecordedRun(report, port) as recorded:
        typer.echo(f'watch it at {recorded.url}', err=True)
        pace = _Pace(rate)
        for time_s in recorded:
            pace.wait_for(time_s)
        recorded.end('end of the recording; the slider goes back')
        _stay(end)


def _stay(end: bool) -> None:
    if not end:
        typer.echo('the run has ended; the page stays open until Ctrl-C', err=True)
        threading.Event().wait()


class _Pace:
    """Throttle to recorded time at a playback rate; rate 0 does not wait."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._begun: tuple[float, float] | None = None

    def wait_for(self, recorded_s: float) -> None:
        """Wait until the recorded time [s] is due."""
        if self._rate <= 0.0:
            return
        now = time.monotonic()
        if self._begun is None:
            self._begun = (now, recorded_s)
        due = self._begun[0] + (recorded_s - self._begun[1]) / self._rate
        time.sleep(max(0.0, due - now))
