# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Execute docs/tour.ipynb in an empty folder, and write its outputs into it and docs/tour.md.

Run: python tools/notebook.py [--out DOCS]

The notebook's cells are the source of the outputs, the page and the images. Images have a
palette, so that the notebook stays small enough for browsers.
"""

import argparse
import base64
from collections.abc import Iterator
import io
import os
from pathlib import Path
import re
import shlex
import subprocess
import sys
import tempfile
from typing import Any

from IPython.core.interactiveshell import InteractiveShell
from IPython.core.pylabtools import select_figure_formats
from IPython.utils.capture import capture_output
from matplotlib import pyplot
import nbformat
from PIL import Image

DOCS = Path(__file__).resolve().parents[1] / 'docs'
NAME = 'tour.ipynb'
COLOURS = 64
SHOWN = ('image/png', 'text/html', 'text/plain')
EMBEDDED = re.compile(r'data:image/png;base64,([A-Za-z0-9+/=]+)')
MADE = '<!-- python tools/notebook.py makes this page of tour.ipynb -->\n'
Cell = Any


class CellError(Exception):
    """Failed cell; the text holds the cell and its exception."""


def main() -> None:
    """Execute the notebook and write notebook, page and images."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--out', type=Path, default=DOCS)
    out = parser.parse_args().out
    notebook = nbformat.read(DOCS / NAME, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        execute(notebook.cells, Path(folder))
    (out / 'images').mkdir(parents=True, exist_ok=True)
    nbformat.write(notebook, out / NAME)
    (out / 'tour.md').write_text(page(notebook.cells, out / 'images'), encoding='utf-8')


def execute(cells: list[Cell], folder: Path) -> None:
    """Run all code cells in a folder and store the outputs in them."""
    pyplot.switch_backend('Agg')
    # Put the programs of this environment on the path, as activating it does.
    os.environ['PATH'] = f'{Path(sys.executable).parent}{os.pathsep}{os.environ["PATH"]}'
    shell, before = quiet_shell(), Path.cwd()
    os.chdir(folder)
    try:
        for number, cell in enumerate((c for c in cells if c.cell_type == 'code'), start=1):
            cell.execution_count, cell.outputs = number, list(shown_by(shell, cell.source))
    finally:
        os.chdir(before)


def quiet_shell() -> InteractiveShell:
    """Return a shell that prints no results and captures the output of programs."""
    shell = InteractiveShell.instance()
    select_figure_formats(shell, {'png'}, dpi=60)
    for name in ('write_output_prompt', 'write_format_data', 'finish_displayhook'):
        setattr(shell.displayhook, name, lambda *_, **__: None)
    shell.system = lambda line: print(run(line), end='')
    return shell


def run(line: str) -> str:
    """Run a program and return its output."""
    words = shlex.split(line)
    done = subprocess.run(words, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != 0:
        raise CellError(f'{line}\n{done.stderr}')
    return done.stdout


def shown_by(shell: InteractiveShell, source: str) -> Iterator[Cell]:
    """Yield the printed, displayed and returned outputs of a cell."""
    with capture_output() as captured:
        result = shell.run_cell(source)
    if not result.success:
        error = result.error_in_exec or result.error_before_exec
        raise CellError(f'{source}\n{error!r}')
    pyplot.close('all')
    if captured.stdout:
        yield nbformat.v4.new_output('stream', name='stdout', text=captured.stdout)
    for output in captured.outputs:
        yield nbformat.v4.new_output('display_data', small(output.data))
    if result.result is not None:
        data, _ = shell.display_formatter.format(result.result)
        yield nbformat.v4.new_output('display_data', small(data))


def small(data: dict[str, Any]) -> dict[str, str]:
    """Return the displayable formats of an output, images with a palette."""
    found = {kind: data[kind] for kind in SHOWN if kind in data}
    if 'image/png' in found:
        found['image/png'] = encoded(paletted(found['image/png']))
    if 'text/html' in found:
        found['text/html'] = EMBEDDED.sub(
            lambda match: f'data:image/png;base64,{encoded(paletted(match[1]))}',
            found['text/html'],
        )
    return found


def paletted(png: str | bytes) -> bytes:
    """Return an image with few colours."""
    data = png if isinstance(png, bytes) else base64.b64decode(png)
    picture = (
        Image.open(io.BytesIO(data)).convert('RGB').quantize(COLOURS, dither=Image.Dither.NONE)
    )
    file = io.BytesIO()
    picture.save(file, 'PNG', optimize=True)
    return file.getvalue()


def encoded(png: bytes) -> str:
    """Return an image as base64 text."""
    return base64.b64encode(png).decode('ascii')


def page(cells: list[Cell], images: Path) -> str:
    """Return the notebook as a Markdown page; its images are written to ``images``."""
    parts, count = [], 0
    for cell in cells:
        if cell.cell_type == 'markdown':
            parts.append(cell.source)
            continue
        parts.append(f'```python\n{cell.source}\n```')
        for output in cell.outputs:
            said, picture = shown(output)
            parts += [f'```\n{said.rstrip()}\n```'] if said.strip() else []
            if picture is not None:
                count += 1
                (images / f'tour_{count}.png').write_bytes(picture)
                name = said.strip(' <>\n') or alternative(cell)
                parts.append(f'![{name}](images/tour_{count}.png)')
    title, *others = parts
    return '\n\n'.join([f'{title}\n\n{MADE}', *others]).replace('\n\n\n', '\n\n') + '\n'


def shown(output: Cell) -> tuple[str, bytes | None]:
    """Return the text and the image of an output."""
    if output.output_type == 'stream':
        return output.text, None
    data = output.data
    if 'image/png' in data:
        return '', base64.b64decode(data['image/png'])
    found = EMBEDDED.search(data.get('text/html', ''))
    return data.get('text/plain', ''), base64.b64decode(found[1]) if found else None


def alternative(cell: Cell) -> str:
    """Return an image's alternative text: the comment in the last line of its cell."""
    return cell.source.rpartition('  # ')[2].replace('\n', ' ')


if __name__ == '__main__':
    main()
