# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet bench scale``: accuracy of scales estimated from doors, rooms and walls."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_lab.cli.reports import finish


def command(
    data: Annotated[Path, typer.Option('--data', metavar='DIR', help='Folder of bormann.')] = Path(
        '../shared/data'
    ),
    limit: Annotated[
        int, typer.Option('--limit', min=0, help='Generated drawings of each kind.')
    ] = 200,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Estimate the scale of drawings of known scale, and compare.

    Reports both splits of the real floorplans, bare and furnished; the weights were trained on the
    development split. Figures on left-out buildings are in the manifest of the weights.

    Example: fpnet bench scale --data ../shared/data --json out/scale.json
    """
    tree = common.load(config, settings)
    common.check_input(data)
    from fpnet_lab.evaluation.scale import bench_scale, count_drawings

    with progress('drawings', count_drawings(limit)) as advance:
        report = bench_scale(data, limit, tree.segmentation, advance)
    finish('scale', json_path, report)
