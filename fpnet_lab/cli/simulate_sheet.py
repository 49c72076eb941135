# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet simulate sheet``: a floorplan as people have it, in every format, with the truth."""

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
            'A bare plan, a CAD plot, a coloured sheet, a scan, a photograph, or any mix of them.',
        ),
    ] = 'office',
    json_path: common.JsonOption = None,
) -> None:
    """
    Draw a sheet with a generated storey as people have it, in every format.

    The folder gets sheet.png and .jpg, the same sheet as sheet.pdf, .svg and .dxf (as drawn: a
    scan's or phone picture's before that), truth.json (rooms, doors, the way from building metres
    to pixels and to each file's units), rooms.png (true rooms in pixels), and plan.yaml: the
    storey as a clean map_server floorplan. Of a varied sheet the vector files have what is in the
    building; what is drawn around and over it is in the pictures alone.

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
