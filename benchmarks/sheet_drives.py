# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Is a robot found on the sheets that people have, and how much later than on a clean grid?

Run: python benchmarks/sheet_drives.py [--drives 20] [--seed 1]
     [--set localizer.claim_probability=0.95] [--json OUT]

Each generated building is driven with true odometry and a planar scanner until the first claim: on
its clean floorplan of stated scale, and on its own sheets of every kind and format, as they are
read from files. A claim is wrong that is more than a metre off, in true metres.
"""

from dataclasses import asdict
from pathlib import Path
import tempfile

import numpy as np

from fpnet_core.cli.common import parse_settings
from fpnet_core.config import load_config
from fpnet_lab.cli.reports import print_scores, script_parser, write_report
from fpnet_lab.evaluation.sheet_drives import drives_on_sheets
from fpnet_lab.scores import Score, Units

WRONG_M = 1.0


def scores(name, rows):
    """Return what the drives on one kind of sheet come to."""
    grid_m = {row.seed: row.found_after_m for row in rows if row.sheet == 'grid'}
    mine = [row for row in rows if row.sheet == name]
    found = [row for row in mine if row.found_after_m is not None]
    # Not found is later than anything.
    after_m = [np.inf if row.found_after_m is None else row.found_after_m for row in mine]
    ratio = [row.found_after_m / grid_m[row.seed] for row in found if grid_m[row.seed]]
    error_m = [row.error_m for row in found]
    return (
        Score('sheet', name),
        Score('found', f'{len(found)} of {len(mine)}'),
        Score('wrong', sum(metres > WRONG_M for metres in error_m)),
        Score('doubted', sum(bool(row.doubts) for row in mine)),
        Score('first pose, median', np.median(after_m), Units.METRES.in_title(1)),
        Score('over the grid', np.median(ratio or [np.nan]), Units.NUMBER),
        Score('error', np.median(error_m or [np.nan]), Units.METRES.in_title(2)),
    )


def main() -> None:
    """Print one row per sheet."""
    parser = script_parser(__doc__)
    parser.add_argument('--drives', type=int, default=20)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--set', action='append', default=[], metavar='KEY=VALUE')
    arguments = parser.parse_args()
    config = load_config(None, parse_settings(arguments.set))
    rows = []
    for seed in range(arguments.seed, arguments.seed + arguments.drives):
        with tempfile.TemporaryDirectory() as folder:
            rows += drives_on_sheets(seed, Path(folder), config)
        print(seed, [(row.sheet, row.found_after_m, row.error_m) for row in rows[-8:]], flush=True)
    print_scores(dict.fromkeys(row.sheet for row in rows), lambda name: scores(name, rows))
    write_report(arguments.json, {'drives': [asdict(row) for row in rows]})


if __name__ == '__main__':
    main()
