# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Comparison with an earlier version: both localize the same recordings in one run, in turn.

Run: python benchmarks/two_programs.py cca81ec [--rounds 1] [--seed 9001] [--json OUT]; then
fpnet bench figures two_programs=OUT

Each round records every sensor in a different building (with the current ``fpnet simulate
recording``). Both versions run ``fpnet localize`` on the bag with its floorplan, and with that of
the previous recording, on which every pose is wrong. A first recording is not counted, because it
compiles kernels. The other commit is checked out in a worktree and runs in the same Python
environment.
"""

from itertools import count
import json
import os
from pathlib import Path
import resource
import subprocess
import sys
import tempfile

from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.sim.lidars.sensors import SENSORS

ROOT = Path(__file__).resolve().parents[1]


def run(program, kernels, *words):
    """Run a command of the version in folder ``program``; return its CPU time [s]."""
    environment = os.environ | {'PYTHONPATH': str(program), 'NUMBA_CACHE_DIR': str(kernels)}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, '-m', 'fpnet', *map(str, words)]
    done = subprocess.run(  # noqa: S603
        command, check=False, env=environment, cwd=program, capture_output=True
    )
    if done.returncode not in (0, 3):
        raise SystemExit(done.stderr.decode()[-2000:])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def localized(program, kernels, drive, others):
    """Return a version's results on the correct and on another recording's floorplan."""
    out, truth = drive / 'out.json', ('--truth', drive / 'truth.tum')
    command = program, kernels, 'localize', drive / 'bag', '--json', out, '--floorplan'
    used_s = run(*command, drive / 'floorplan.yaml', *truth)
    own = json.loads(out.read_text(encoding='utf-8'))
    run(*command, others / 'floorplan.yaml')
    other = json.loads(out.read_text(encoding='utf-8'))
    return {**own, 'processor_s': used_s, 'poses_on_others': other['poses']}


def main() -> None:
    """Record, localize, and print the table."""
    parser = script_parser(__doc__)
    parser.add_argument('commit')
    parser.add_argument('--rounds', type=int, default=1)
    parser.add_argument('--seed', type=int, default=9001)
    args = parser.parse_args()
    seeds, drives = count(args.seed), []
    with tempfile.TemporaryDirectory() as folder:
        other = Path(folder) / 'program'
        git = ['git', '-C', str(ROOT), 'worktree']
        subprocess.run([*git, 'add', '--detach', other, args.commit], check=True)  # noqa: S603
        try:
            programs, last = {'earlier': other, 'today': ROOT}, None
            kernels = {name: Path(folder) / f'{name}_kernels' for name in programs}
            sensors = [next(iter(SENSORS)), *args.rounds * tuple(SENSORS)]
            for seed, sensor in zip(seeds, sensors, strict=False):
                drive = Path(folder) / str(seed)
                words = '--out', drive, '--seed', seed, '--sensor', sensor
                run(ROOT, kernels['today'], 'simulate', 'recording', *words)
                found = {
                    name: localized(programs[name], kernels[name], drive, last or drive)
                    for name in sorted(programs, reverse=seed % 2)
                }
                if last is not None:
                    drives.append({'sensor': sensor, **{name: found[name] for name in programs}})
                    print(sensor, seed, _brief(drives[-1]), flush=True)
                last = drive
        finally:
            subprocess.run([*git, 'remove', '--force', other], check=False)  # noqa: S603
    finish('two_programs', args.json, {'commit': args.commit, 'drives': drives})


def _brief(drive):
    return {
        name: (drive[name]['path_to_first_pose_m'], round(drive[name]['processor_s'], 1))
        for name in ('earlier', 'today')
    }


if __name__ == '__main__':
    main()
