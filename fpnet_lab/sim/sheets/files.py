# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Export of a sheet as pictures, PDF, SVG and DXF, with ground truth."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import write_map
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.sheets.artwork import Array
from fpnet_lab.sim.sheets.dxf import draw_dxf_style, write_dxf
from fpnet_lab.sim.sheets.layers import LAYERINGS, SHARES
from fpnet_lab.sim.sheets.looks import SheetKind
from fpnet_lab.sim.sheets.painting import write_pdf
from fpnet_lab.sim.sheets.sheet import Sheet
from fpnet_lab.sim.sheets.svg import write_svg

PICTURES, VECTORS = ('png', 'jpg'), ('pdf', 'svg', 'dxf')
"""File suffixes of raster and vector formats."""

CLEAN_CELL_M = 0.05
"""Cell edge of the clean floorplan written with a sheet. Chosen."""

_POINTS_PER_MM = 72.0 / 25.4  # given
_UNITS_PER_MM = (1.0, 96.0 / 25.4)  # given: SVG in millimetres, and in CSS pixels
_FILE_STREAM, _PICTURE_STREAM = 1, 2  # given: random streams of a sheet's seed for its files

# Chosen, not measured:
_PALETTE_SHARE, _PALETTE_COLOURS = 0.15, 64
_ORIENTATION_TAG = 0x0112  # given
_UPRIGHT = 1  # given
# Rotation of the stored picture relative to the artwork for each EXIF orientation, and the
# picture's x and y axes in the artwork.
_HELD = {
    3: (Image.Transpose.ROTATE_180, (-1.0, 0.0), (0.0, -1.0)),
    6: (Image.Transpose.ROTATE_90, (0.0, 1.0), (-1.0, 0.0)),
    8: (Image.Transpose.ROTATE_270, (0.0, -1.0), (1.0, 0.0)),
}
_HELD_SHARES = (0.6, 0.1, 0.2, 0.1)  # upright, then as above


def write_picture(sheet: Sheet, path: Path) -> Array:
    """
    Write the sheet's pixels as PNG, or as JPEG with transparency replaced by white.

    Some PNGs have a palette; some phone pictures are stored rotated with an EXIF orientation.

    Returns
    -------
    H_file_image : (3, 3)
        Homography from the sheet's pixels to the pixels stored in the file.
    """
    rng = np.random.default_rng([sheet.seed, _PICTURE_STREAM])
    image = Image.fromarray(sheet.pixels)
    if path.suffix == '.png':
        has_palette = image.mode == 'RGB' and not sheet.is_photo and rng.random() < _PALETTE_SHARE
        (image.quantize(_PALETTE_COLOURS) if has_palette else image).save(path)
        return np.eye(3)
    if image.mode == 'RGBA':
        image = Image.alpha_composite(Image.new('RGBA', image.size, 'white'), image)
    orientation = int(rng.choice([_UPRIGHT, *_HELD], p=_HELD_SHARES))
    if sheet.kind is SheetKind.PHONE and orientation != _UPRIGHT:
        return _write_turned(image.convert('RGB'), orientation, path, sheet.jpeg_quality)
    image.convert('RGB').save(path, quality=sheet.jpeg_quality)
    return np.eye(3)


def _write_turned(image: Image.Image, orientation: int, path: Path, quality: int) -> Array:
    """Write a rotated JPEG with EXIF orientation; return the map (3, 3) to its pixels."""
    turn, x, y = _HELD[orientation]
    exif = Image.Exif()
    exif[_ORIENTATION_TAG] = orientation
    image.transpose(turn).save(path, quality=quality, exif=exif)
    # A reversed axis starts at the opposite end.
    last = np.array([image.width - 1.0, image.height - 1.0])
    return np.array(
        [[*row, -float(np.minimum(row, 0.0) @ last)] for row in (x, y)] + [[0.0, 0.0, 1.0]]
    )


def write_vector(sheet: Sheet, path: Path) -> dict[str, Any]:
    """
    Write the sheet's artwork, without scan effects, as PDF, SVG or DXF by suffix.

    Returns
    -------
    dict for JSON: ``A_file_page`` from page metres to the file's units, and other properties of
    the file
    """
    rng = np.random.default_rng([sheet.seed, _FILE_STREAM])
    layering = str(rng.choice(list(SHARES), p=list(SHARES.values())))
    units_per_mm = float(rng.choice(_UNITS_PER_MM))
    style = draw_dxf_style(rng)
    known: dict[str, Any] = {'layers': {}}
    if path.suffix == '.pdf':
        write_pdf(sheet.artwork, path)
        per_m = _POINTS_PER_MM * 1e3 / sheet.artwork.denominator
        top = sheet.artwork.size_m[1] * per_m
        A = Affine2D(np.diag([per_m, -per_m]), np.array([0.0, top]))
        return {**known, 'A_file_page': A.matrix.tolist()}
    known['layers'] = {role.value: name for role, name in LAYERINGS[layering].items()}
    if path.suffix == '.svg':
        A = write_svg(sheet.artwork, path, LAYERINGS[layering], units_per_mm)
        return {**known, 'A_file_page': A.matrix.tolist()}
    A = write_dxf(sheet.artwork, path, LAYERINGS[layering], style)
    return {**known, 'A_file_page': A.matrix.tolist(), 'unit': style.unit}


def write_sheet(sheet: Sheet, folder: Path) -> dict[str, Any]:
    """
    Write a sheet in every format, its ground truth, and each storey as a map_server floorplan.

    The folder contains ``sheet.png``, ``.jpg``, ``.pdf``, ``.svg``, ``.dxf``, ``truth.json``,
    ``rooms.png`` (true rooms in the picture's pixels) and ``plan.yaml``, for a second storey
    ``plan-2.yaml``. Returns the content of ``truth.json``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files: dict[str, Any] = {}
    for suffix in PICTURES:
        H_file_image = write_picture(sheet, folder / f'sheet.{suffix}')
        files[suffix] = {'H_file_image': H_file_image.tolist()}
    files |= {suffix: write_vector(sheet, folder / f'sheet.{suffix}') for suffix in VECTORS}
    truth = {**sheet.truth(), 'files': files}
    (folder / 'truth.json').write_text(json.dumps(truth, indent=1) + '\n', encoding='utf-8')
    Image.fromarray(sheet.room_labels().astype(np.uint16)).save(folder / 'rooms.png')
    for number, storey in enumerate(sheet.storeys, start=1):
        file = 'plan.yaml' if number == 1 else f'plan-{number}.yaml'
        write_map(render_plan(storey.plan, CLEAN_CELL_M), folder / file)
    return truth
