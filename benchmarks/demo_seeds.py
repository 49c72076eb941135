# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Run the demo for several seeds and print the table that the README shows.

Run: python benchmarks/demo_seeds.py [--seeds 10] [--out out/seeds]

Every run is the whole demo: a fresh building and recording, four processes, real time.
"""

import argparse
import json
from pathlib import Path
import subprocess
import sys

COLUMNS = {
    'poses': 'poses',
    'wrong_poses': 'wrong',
    'time_to_first_pose_s': 'first pose [s]',
    'path_to_first_pose_m': 'after [m]',
    'median_position_error_m': 'position [m]',
    'median_yaw_error_deg': 'yaw [deg]',
    'tick_ms_p50': 'tick p50 [ms]',
    'tick_ms_p95': 'tick p95 [ms]',
}
TARGET_POSITION_M, TARGET_YAW_DEG = 0.5, 3.0


def main() -> None:
    """Run, then print a Markdown table and how many seeds met the target."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', type=int, default=10)
    parser.add_argument('--out', type=Path, default=Path('out/seeds'))
    arguments = parser.parse_args()
    rows, met = [], 0
    for seed in range(arguments.seeds):
        out = arguments.out / str(seed)
        command = [sys.executable, '-m', 'fpnet_core.cli', 'demo']
        subprocess.run([*command, '--seed', str(seed), '--out', str(out)], check=False)  # noqa: S603
        result = json.loads((out / 'result.json').read_text(encoding='utf-8'))
        met += is_met(result)
        rows.append([seed, *(show(result[key]) for key in COLUMNS)])
    print('| seed | ' + ' | '.join(COLUMNS.values()) + ' |')
    print('|---' * (len(COLUMNS) + 1) + '|')
    for row in rows:
        print('| ' + ' | '.join(map(str, row)) + ' |')
    print(f'\n{met} of {arguments.seeds} seeds within 0.5 m and 3 degrees without a wrong pose')


def is_met(result: dict) -> bool:
    """Say whether a run met the target."""
    return bool(
        result['localized']
        and result['wrong_poses'] == 0
        and result['median_position_error_m'] <= TARGET_POSITION_M
        and result['median_yaw_error_deg'] <= TARGET_YAW_DEG
    )


def show(value: float | None) -> str:
    """Round a figure for the table."""
    if value is None:
        return '-'
    return str(value) if isinstance(value, int) else f'{value:.2f}'


if __name__ == '__main__':
    main()
