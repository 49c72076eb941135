# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Install the wheel into fresh environments, for each Python and each extra, and test it.

Run: python tools/wheels.py [--python PYTHON ...] [--extra EXTRA ...] [--work DIR]
                            [--with-cuda] [--json OUT]                     (make wheels)

Without ``--python`` it uses the interpreters 3.11 to 3.13 on the path or in pyenv. It installs
the wheel without extras first; each extra goes into a hard-linked copy of that environment, so
that extras do not share libraries. It prints a row for each and exits 1 if any of them fails.

``--with-cuda`` is for machines without access to PyTorch's index: they install PyPI's build, with
several GB of CUDA libraries. `fpnet bench figures wheels=OUT` writes the installation times and
sizes into docs/install.md.
"""

from collections.abc import Iterator
from pathlib import Path
import shutil
import subprocess
import sys
import tempfile
import time

from fpnet_lab.cli.reports import finish, script_parser

ROOT = Path(__file__).resolve().parents[1]
VERSIONS = ('3.11', '3.12', '3.13')
PYENV = Path.home() / '.pyenv' / 'versions'
NONE = 'none'
WITH_TORCH = ('train', 'lab')

PLAN = """
from PIL import Image, ImageDraw
plan = Image.new('L', (900, 600), 255)
pen = ImageDraw.Draw(plan)
for room in ((20, 20, 880, 580), (20, 20, 400, 580), (400, 300, 880, 580)):
    pen.rectangle(room, outline=0, width=8)
for door in ((390, 120, 410, 165), (390, 420, 410, 465)):
    pen.rectangle(door, fill=255)
plan.save('plan.png')
"""
DRIVE = """
import numpy as np
from PIL import Image
from fpnet_core.geometry import SE2
from fpnet.bag_writer import BagWriter
PIXEL_M, SCAN_NS, FIRST_NS = 0.02, 100_000_000, 10**18
wall = np.array(Image.open('plan.png')) < 128
down = np.array([(200, y) for y in range(300, 142, -5)])
path = np.vstack([down, [(x, 142) for x in range(200, 600, 5)]])
angle = np.arange(0.0, 2.0 * np.pi, np.radians(0.5))
ray = np.column_stack([np.cos(angle), -np.sin(angle)])
with BagWriter('drive') as bag:
    for number, here in enumerate(path):
        along = (here + np.arange(700)[:, None, None] * ray).astype(int)
        hit = wall[along[..., 1].clip(0, 599), along[..., 0].clip(0, 899)].argmax(axis=0)
        points = np.column_stack([hit[:, None] * PIXEL_M * ray * [1, -1], np.zeros(len(ray))])
        x, y = PIXEL_M * (here - path[0]) * [1, -1]
        turned = SE2.from_xy_yaw(0, 0, 0.7) @ SE2.from_xy_yaw(x, y, 0)
        stamp_ns = FIRST_NS + number * SCAN_NS
        bag.write_cloud('/points', stamp_ns, 'base', points.astype(np.float32))
        bag.write_odometry('/odom', stamp_ns, 'odom', 'base', turned.as_matrix4())
"""
MAP = """image: plan.png
resolution: 0.02
origin: [0, 0, 0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
PLY = 'from fpnet_core.io.clouds import read_cloud; print(len(read_cloud("cloud.ply")))'
CLOUD = """ply
format ascii 1.0
element vertex 1
property float x
property float y
property float z
end_header
1 2 3
"""
USES = {
    NONE: [
        'fpnet --version',
        'fpnet segment plan.yaml --json -',
        'fpnet localize drive --floorplan plan.yaml',
    ],
    'plans': ['python -c "import ezdxf, pypdfium2, svgelements"'],
    'report': ['fpnet check-plan plan.yaml --tours 0 --out check'],
    'clouds': [f"python -c '{PLY}'"],
    'e57': ['python -c "import pye57"'],
    'laz': ['python -c "import laspy, lazrs"'],
    'ifc': ['python -c "import ifcopenshell"'],
    'cluster': ['python -c "import distributed"'],
    'peers': ['python -c "import map_closures.map_closures"'],
    'train': ['python -c "import lightning_fabric, onnx, torch"'],
    'ros': ['python -c "import fpnet_ros.localizer"'],
    'lab': ['fpnet simulate stats --help', 'python -c "import fpnet_lab.evaluation.demo"'],
}
"""Test commands for each extra; they run in a folder with a plan, a recording and a cloud."""


def main() -> None:
    """Test every Python with every extra."""
    parser = script_parser(__doc__)
    parser.add_argument('--python', action='append', type=Path)
    parser.add_argument('--extra', action='append', choices=[*USES], default=[])
    parser.add_argument('--work', type=Path, help='keeps the environments')
    parser.add_argument('--with-cuda', action='store_true')
    arguments = parser.parse_args()
    work = arguments.work or Path(tempfile.mkdtemp(prefix='wheels-'))
    work.mkdir(parents=True, exist_ok=True)
    wheel = built(work)
    found = [
        tried(wheel, python, extra, work, arguments.with_cuda)
        for python in arguments.python or at_hand()
        for extra in arguments.extra or USES
    ]
    if arguments.work is None:
        shutil.rmtree(work)
    installed = [each for each in found if each is not None]
    if any(each['extra'] == NONE for each in installed):
        finish('wheels', arguments.json, {'environments': installed})
    sys.exit(None in found)


def at_hand() -> Iterator[Path]:
    """Yield an interpreter of each installed version."""
    for version in VERSIONS:
        on_path = shutil.which(f'python{version}')
        found = [*([on_path] if on_path else []), *sorted(PYENV.glob(f'{version}.*/bin/python'))]
        # The path may hold pyenv's shim of a version that is not active, which does not run.
        runs = next((Path(each) for each in found if is_running(each)), None)
        if runs is None:
            print(f'Python {version} is not installed')
        else:
            yield runs


def is_running(python: str | Path) -> bool:
    """Return whether an interpreter starts."""
    done = subprocess.run(  # noqa: S603 - our own arguments
        [python, '-c', ''], capture_output=True, check=False
    )
    return done.returncode == 0


def built(work: Path) -> Path:
    """Return the wheel of this checkout's commit, built from a clone without old build files."""
    sources = work / 'sources'
    shutil.rmtree(sources, ignore_errors=True)
    run('git', 'clone', '-q', '--shared', ROOT, sources)
    run(sys.executable, '-m', 'pip', 'wheel', '-q', '--no-deps', '-w', work, sources)
    [wheel] = work.glob('*.whl')
    return wheel


def tried(
    wheel: Path, python: Path, extra: str, work: Path, with_cuda: bool
) -> dict[str, object] | None:
    """Return size and installation time of an extra; None if installation or use fails."""
    version = run(python, '-c', 'import sys; print("%d.%d" % sys.version_info[:2])').strip()
    started = time.monotonic()
    try:
        home = environment(wheel, python, extra, work / version, with_cuda)
        for use in USES[extra]:
            run('bash', '-c', use, cwd=home, path=home / 'bin')
    except subprocess.CalledProcessError as error:
        print(f'{version} {extra}: failed\n{error.stdout}{error.stderr}', flush=True)
        return None
    size, seconds = int(run('du', '-sm', home).split()[0]), time.monotonic() - started
    print(f'{version} {extra}: {size} MB, {seconds:.0f} s', flush=True)
    return {'python': version, 'extra': extra, 'megabytes': size, 'seconds': seconds}


def environment(wheel: Path, python: Path, extra: str, folder: Path, with_cuda: bool) -> Path:
    """Return a new environment with the wheel and one extra."""
    home = folder / extra
    shutil.rmtree(home, ignore_errors=True)
    if extra == NONE:
        run(python, '-m', 'venv', home)
    else:
        if not (folder / NONE).is_dir():
            environment(wheel, python, NONE, folder, with_cuda)
        run('cp', '-al', folder / NONE, home)
        run(python, '-m', 'venv', '--upgrade', home)
    pip = (home / 'bin' / 'python', '-m', 'pip', 'install', '-q', '--no-input')
    pip += ('--disable-pip-version-check',)
    # Also in a copy: its scripts refer to the environment that they were copied from.
    run(*pip, '--force-reinstall', '--no-deps', wheel)
    is_limited = extra in WITH_TORCH and not with_cuda
    limits = ('-c', ROOT / 'constraints-cpu.txt') if is_limited else ()
    run(*pip, *limits, wheel if extra == NONE else f'{wheel}[{extra}]')
    run(home / 'bin' / 'python', '-c', PLAN, cwd=home)
    shutil.rmtree(home / 'drive', ignore_errors=True)
    run(home / 'bin' / 'python', '-c', DRIVE, cwd=home)
    (home / 'plan.yaml').write_text(MAP, encoding='utf-8')
    (home / 'cloud.ply').write_text(CLOUD, encoding='utf-8')
    return home


def run(*words: object, cwd: Path | None = None, path: Path | None = None) -> str:
    """Run a program and return its output."""
    environment = {'PATH': f'{path}:/usr/bin:/bin'} if path else None
    done = subprocess.run(  # noqa: S603 - our own commands
        [str(word) for word in words], cwd=cwd, env=environment, capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    return done.stdout


if __name__ == '__main__':
    main()
