# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Run of the demo for several seeds, and the table in docs/benchmarks.md.

Run: python benchmarks/demo_seeds.py [--seeds 10] [--out out/seeds] [--json OUT]; then
fpnet bench figures demo=OUT

Every run is the complete demo: a new building and recording, four processes, real time.
"""

import json
from pathlib import Path
import subprocess
import sys

from fpnet_lab.cli.reports import finish, script_parser


def main() -> None:
    """Run the demos and print the table."""
    parser = script_parser(__doc__)
    parser.add_argument('--seeds', type=int, default=10)
    parser.add_argument('--out', type=Path, default=Path('out/seeds'))
    arguments = parser.parse_args()
    seeds = {}
    for seed in range(arguments.seeds):
        out = arguments.out / str(seed)
        demo = [sys.executable, '-m', 'fpnet', 'demo']
        subprocess.run([*demo, '--seed', str(seed), '--out', str(out)], check=False)  # noqa: S603
        seeds[str(seed)] = json.loads((out / 'result.json').read_text(encoding='utf-8'))
    finish('demo', arguments.json, {'seeds': seeds})


if __name__ == '__main__':
    main()
