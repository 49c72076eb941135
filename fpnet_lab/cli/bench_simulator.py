# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench simulator``: pairs, plans and scans per second on this machine."""

from __future__ import annotations

from typing import Annotated

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_lab.cli import options
from fpnet_lab.cli.reports import finish


def command(
    workers: options.WorkersOption = 2,
    blocks: Annotated[
        int, typer.Option('--blocks', min=2, help='Blocks of 40 pairs; the first ones warm up.')
    ] = 12,
    seed: common.SeedOption = 0,
    json_path: common.JsonOption = None,
) -> None:
    """
    Measure the simulator on storeys of about 30 rooms.

    Pairs are complete: ray casting, segmentation of both maps, and writing to disk. Scans are
    sweeps of a 32-beam lidar in a furnished building.

    Example: fpnet bench simulator --json out/simulator.json
    """
    from fpnet_core.errors import ConfigError
    from fpnet_lab.sim.pairs.writing import BLOCK_PAIRS
    from fpnet_lab.sim.throughput import simulator_throughput

    if blocks <= workers:
        raise ConfigError(f'--blocks {blocks}: expected more than --workers {workers}')
    with progress('pairs', total=blocks * BLOCK_PAIRS) as advance:
        report = simulator_throughput(seed or 0, workers, blocks, on_pairs=advance)
    finish('simulator', json_path, report)
