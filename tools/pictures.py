# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Make the pictures of the pages by the commands that notes/images.md shows.

Run: python tools/pictures.py [NAME ...]

Without names, makes all of them, in the order of the page. A picture whose commands read
../shared/data is left out where there is none. Needs Chromium for those of reports.
"""

import argparse
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / 'notes' / 'images.md'
IMAGES = ROOT / 'docs' / 'images'
COLOURS = 256  # given: the most of a palette; a page of pictures loads on a phone


def recipes() -> dict[str, str]:
    """Return the commands of each picture of the page, by the picture's file name."""
    text = PAGE.read_text(encoding='utf-8')
    sections = re.split(r'^## ', text, flags=re.MULTILINE)[1:]
    found = {}
    for section in sections:
        title, _, body = section.partition('\n')
        commands = '\n'.join(re.findall(r'```bash\n(.*?)```', body, re.DOTALL))
        for name in re.findall(r'`([\w.]+)`', title):
            found[name] = commands
    return found


def make(commands: str) -> None:
    """Run commands from the root of the checkout, with its environment's programs first."""
    path = f'{Path(sys.executable).parent}{os.pathsep}{os.environ["PATH"]}'
    environment = {**os.environ, 'PATH': path}
    shell = ['bash', '-euxc', commands]
    subprocess.run(shell, cwd=ROOT, env=environment, check=True)  # noqa: S603 - our own page


def reduce(name: str) -> None:
    """Reduce a PNG to few colours; charts and floorplans have no more."""
    if name.endswith('.png'):
        picture = Image.open(IMAGES / name).convert('RGB')
        reduced = picture.quantize(COLOURS, dither=Image.Dither.NONE)
        reduced.save(IMAGES / name, optimize=True)


def main() -> None:
    """Make the pictures that were named."""
    known = recipes()
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('names', nargs='*', metavar='NAME', help=', '.join(known))
    names = parser.parse_args().names or list(known)
    if unknown := [name for name in names if name not in known]:
        parser.error(f'{PAGE.relative_to(ROOT)} has no {", ".join(unknown)}')
    shutil.rmtree(ROOT / 'out' / 'pictures', ignore_errors=True)  # recordings are not overwritten
    done: set[str] = set()
    for name in names:
        commands = known[name]
        if '../shared/data' in commands and not (ROOT.parent / 'shared' / 'data').is_dir():
            print(f'{name}: left out, ../shared/data is missing')
            continue
        if commands not in done:
            make(commands)
            done.add(commands)
        reduce(name)


if __name__ == '__main__':
    main()
