# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet plan``: a drawing of any kind as a map_server map, and how it was read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common, verdicts
from fpnet_core.errors import ConfigError, MapFormatError

if TYPE_CHECKING:
    from fpnet_core.drawings.types import Reading

_OutOption = Annotated[
    Path,
    typer.Option(
        '--out', metavar='FILE', help='The map to write; its image and record lie beside it.'
    ),
]
_ExportOption = Annotated[
    list[Path] | None,
    typer.Option(
        '--export',
        metavar='FILE',
        help='Rooms and doors as .geojson, .zip (IMDF), .building.yaml, .dxf or .svg.',
    ),
]


@common.reads_drawing
def command(
    drawing: Annotated[Path, typer.Argument(metavar='DRAWING', help=common.DRAWING_HELP)],
    said: common.DrawingOptions,
    out: _OutOption = Path('plan.yaml'),
    export: _ExportOption = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    accept: verdicts.AcceptOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Read a drawing as a floorplan and write it as a map of map_server.

    Beside plan.yaml and plan.png lie plan.json (from pixels of the drawing to metres, scale with
    its interval and where it is from, how it was read, what was left out, storeys, doubts) and
    plan_reading.png, the reading over the drawing with the numbers of rooms and doors. Every
    command reads plan.yaml as it reads the drawing, with the same scale and as surely.

    Look at the picture. Where it is wrong: --crop or --storey for another part of the sheet,
    --length or --resolution for its scale. Exits 1 where fpnet check-plan would: where the
    reading or its scale is doubtful, or the file is no floorplan, of which nothing is written.
    --accept takes it all the same, and records why.

    Example: fpnet plan sheet.pdf --page 2 --out plan.yaml

    Example: fpnet plan storey.ifc --export storey.geojson --export storey.building.yaml

    Example: fpnet plan phone.jpg --length 120,80,520,80=6.0 --crop 40,60,900,700 --out plan.yaml
    """
    tree = common.load(config, settings)
    from fpnet.plan_check.verdict import Fitness
    from fpnet.viz.reading import save_reading
    from fpnet_core.drawings.plan_files import as_json, write_plan
    from fpnet_core.drawings.wording import said_of
    from fpnet_core.scoring.invocation import Invocation

    picture = _checked(out, drawing)
    exports = _checked_exports(export or [], drawing)
    invocation = Invocation(('fpnet', 'plan'), str(drawing), (*said.pairs(), ('--out', str(out))))
    with verdicts.refusal_as_json(invocation, json_path):
        reading = verdicts.accepting(said.read(drawing, tree), accept)
    verdict = verdicts.verdict_on(reading, tree, invocation, str(picture))
    segmentation = reading.segmentation
    figures: dict[str, Any] = {'rooms': len(segmentation.rooms), 'doors': len(segmentation.doors)}
    figures |= {'verdict': verdict.as_json()}
    common.write_json(json_path, as_json(reading) | figures)
    if verdict.fitness is Fitness.NO_FLOORPLAN and not verdict.is_usable:
        raise MapFormatError(verdict.said_of_file(drawing.name))
    record = write_plan(reading, out)
    lines = [*said_of(reading), *verdict.lines()]
    save_reading(reading, picture, verdict)
    for line in lines:
        common.say(line, json_path)
    common.say(f'wrote {out}, {record.name} and {picture.name}', json_path)
    _export(reading, exports, json_path)
    if not verdict.is_usable:
        raise typer.Exit(1)


def _checked_exports(exports: list[Path], drawing: Path) -> list[Path]:
    """Return the files to export to; an error for ones that must not be written."""
    from fpnet.cli.outputs import check_file
    from fpnet_core.drawings.exports.writing import export_suffix

    for path in exports:
        export_suffix(path)
        check_file(path, '--export')
        if path.resolve() == drawing.resolve():
            raise ConfigError(f'--export {path} would overwrite the drawing; name another file')
    return exports


def _export(reading: Reading, exports: list[Path], json_path: Path | None) -> None:
    """Write the reading's model to each file."""
    if not exports:
        return
    from fpnet_core.drawings.exports.writing import write_model
    from fpnet_core.drawings.segmented_model import complete_model

    model = complete_model(reading)
    for path in exports:
        write_model(model, path, Path(reading.drawing.name).stem)
        counts = f'{len(model.rooms)} rooms and {len(model.doors)} doors'
        common.say(f'wrote {path}: {counts}', json_path)


def _checked(out: Path, drawing: Path) -> Path:
    """Return where the picture goes; ConfigError for files that must not be written."""
    from fpnet_core.drawings.plan_files import picture_path
    from fpnet_core.io.maps import YAML_SUFFIXES

    if out.suffix.lower() not in YAML_SUFFIXES:
        raise ConfigError(f'--out {out}: expected a YAML file, as {out.with_suffix(".yaml")}')
    picture = picture_path(out)
    written = {path.resolve() for path in (out, out.with_suffix('.png'), picture)}
    if drawing.resolve() in written:
        raise ConfigError(
            f'--out {out} would overwrite the drawing {drawing}; write to another folder, as '
            f'--out {Path("out") / out.name}'
        )
    return picture
