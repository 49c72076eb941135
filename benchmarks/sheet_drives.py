# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Localization on realistic sheets, compared with a clean floorplan.

Run: python benchmarks/sheet_drives.py [--drives 20] [--seed 1]
     [--set localizer.accept_probability=0.95] [--json OUT]; then
fpnet bench figures sheet_drives=OUT

In each generated building, a robot with true odometry and a planar scanner drives until the first
acceptance: on the clean floorplan with stated scale, and on the building's sheets of every kind
and format, parsed from files. An acceptance is wrong if its error exceeds 1 m, in true metres.
"""

from dataclasses import asdict
from pathlib import Path
import tempfile

from fpnet.cli.common import parse_settings
from fpnet_core.config import load_config
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.evaluation.sheet_drives import drives_on_sheets


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
    finish('sheet_drives', arguments.json, {'drives': [asdict(row) for row in rows]})


if __name__ == '__main__':
    main()
