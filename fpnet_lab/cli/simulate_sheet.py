# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet simulate sheet``: a realistic floorplan sheet in every format, with the truth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from fpnet.cli import common

_Kind = Literal['clean', 'office', 'brochure', 'scan', 'phone', 'varied']


def command(
    out: common.OutOption = None,
    seed: common.SeedOption = 0,
    kind: Annotated[
        _Kind,
        common.choice(
            '--kind',
            _Kind,
            'A bare plan, a CAD plot, a coloured sheet, a scan, a photograph, or a random mix.',
        ),
    ] = 'office',
    json_path: common.JsonOption = None,
) -> None:
    """
    Draw a realistic sheet with a generated storey, in every format.

    The folder gets sheet.png and .jpg, the same sheet as sheet.pdf, .svg and .dxf (for scans and
    phone pictures before the scan), truth.json (rooms, doors, transforms from building metres to
    pixels and to each file's units), rooms.png (true rooms in pixels), and plan.yaml: the storey
    as a clean map_server floorplan. Vector files of a varied sheet hold the building only; its
    surroundings and overlays are in the images only.

    Example: fpnet simulate sheet --seed 3 --kind office --out out/sheet

    Example: fpnet simulate sheet --seed 7 --kind varied --out out/varied
    """
    from fpnet_lab.sim.sheets import draw_sheet
    from fpnet_lab.sim.sheets.files import write_sheet

    folder = out if out is not None else Path('out') / 'sheet'
    sheet = draw_sheet(seed or 0, kind)
    truth = write_sheet(sheet, folder)
    common.write_json(json_path, truth)
    width, height = truth['size_px']
    common.say(
        f'{truth["storeys"][0]["family"]}: {truth["rooms"]} rooms, {truth["walls"]} walls, '
        f'1:{sheet.look.denominator}, {width} x {height} pixels of '
        f'{truth["resolution_m"]:.4f} m; written to {folder}',
        json_path,
    )
