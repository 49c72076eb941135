# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The notebook of the documentation: executed as it stands, it shows what the page shows."""

import importlib.util
from pathlib import Path
import sys

import nbformat
import pytest

ROOT = Path(__file__).resolve().parents[2]
MAX_BYTES = 300_000
STATED = nbformat.read(ROOT / 'docs' / 'tour.ipynb', as_version=4)


def tool(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / 'tools' / f'{name}.py')
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


notebook, walkthrough = tool('notebook'), tool('walkthrough')


def lines(cell):
    return [line for out in cell.outputs for line in notebook.shown(out)[0].splitlines()]


def test_it_is_valid_executed_and_small():
    nbformat.validate(STATED)
    cells = [cell for cell in STATED.cells if cell.cell_type == 'code']
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    assert sum(bool(cell.outputs) for cell in cells) >= 6
    assert (ROOT / 'docs' / 'tour.ipynb').stat().st_size < MAX_BYTES


def test_the_page_is_made_of_it(tmp_path):
    made = notebook.page(STATED.cells, tmp_path)
    assert made == (ROOT / 'docs' / 'tour.md').read_text(encoding='utf-8')
    pictures = sorted(tmp_path.iterdir())
    assert len(pictures) >= 3
    for picture in pictures:
        assert picture.read_bytes() == (ROOT / 'docs' / 'images' / picture.name).read_bytes()


@pytest.mark.slow
@pytest.mark.apart
def test_executed_again_it_shows_the_same(tmp_path):
    cells = nbformat.read(ROOT / 'docs' / 'tour.ipynb', as_version=4).cells
    for cell in cells:
        cell.outputs = []
    notebook.execute(cells, tmp_path)
    for stated, cell in zip(STATED.cells, cells, strict=True):
        if stated.cell_type == 'code':
            assert walkthrough.missing(tuple(lines(stated)), lines(cell)) == [], cell.source
            assert len(cell.outputs) == len(stated.outputs)


@pytest.mark.slow
@pytest.mark.apart
def test_a_cell_that_fails_is_named(tmp_path):
    cells = [nbformat.v4.new_code_cell('1 / 0')]
    with pytest.raises(notebook.CellError, match='1 / 0\nZeroDivisionError'):
        notebook.execute(cells, tmp_path)
