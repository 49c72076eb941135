# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench``: registers the benchmarks, one module ``bench_<name>.py`` each."""

from __future__ import annotations

import typer

from fpnet_lab.cli import (
    bench_calibration,
    bench_drawings,
    bench_figures,
    bench_localization,
    bench_matching,
    bench_open,
    bench_peers,
    bench_regression,
    bench_scale,
    bench_segmentation,
    bench_simulator,
    bench_sites,
    bench_speed,
)
from fpnet_lab.cli.reports import begin

app = typer.Typer(help='Compare methods on the same inputs.', no_args_is_help=True)
app.command('calibration')(bench_calibration.command)
app.command('drawings')(bench_drawings.command)
app.command('figures')(bench_figures.command)
app.command('matching')(bench_matching.command)
app.command('localization')(bench_localization.command)
app.add_typer(bench_open.app, name='open')
app.command('peers')(bench_peers.command)
app.command('regression')(bench_regression.command)
app.command('scale')(bench_scale.command)
app.command('segmentation')(bench_segmentation.command)
app.command('simulator')(bench_simulator.command)
app.command('sites')(bench_sites.command)
app.command('speed')(bench_speed.command)


@app.callback()
def _group() -> None:
    """
    Compare methods on the same inputs.

    Example: fpnet bench matching --data runs/pairs-test --limit 400
    """
    begin()
