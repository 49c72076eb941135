# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet plan``: convert a drawing to a map_server map, and show how it was parsed."""

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
        '--out', metavar='FILE', help='Map YAML to write; its image and JSON go beside it.'
    ),
]
_ExportOption = Annotated[
    list[Path] | None,
    typer.Option(
        '--export',
        metavar='FILE',
        help='Also write rooms and doors: .geojson, .zip (IMDF), .building.yaml, .dxf or .svg.',
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
    Convert a drawing to a floorplan, written as a map_server map.

    plan.json and plan_reading.png go beside plan.yaml and plan.png: the transform from pixels to
    metres, the scale with its interval and source, the parse with warnings, and a plot of the
    result over the drawing with the numbers of rooms and doors. Every command reads plan.yaml
    with the same scale and interval as the drawing.

    Check the plot. If it is wrong, use --crop or --storey for another part of the sheet, --length
    or --resolution for the scale. Exits with 1, like fpnet check-plan, if the parse or scale is
    doubtful or the file is no floorplan; in the latter case nothing is written. --accept
    overrides the verdict and records why.

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
    """Return the export files; raise an error if one must not be written."""
    from fpnet.cli.outputs import check_file
    from fpnet.exports.writing import export_suffix

    for path in exports:
        export_suffix(path)
        check_file(path, '--export')
        if path.resolve() == drawing.resolve():
            raise ConfigError(f'--export {path} would overwrite the drawing; name another file')
    return exports


def _export(reading: Reading, exports: list[Path], json_path: Path | None) -> None:
    """Write the rooms and doors to each export file."""
    if not exports:
        return
    from fpnet.exports.segmented_model import complete_model
    from fpnet.exports.writing import write_model

    model = complete_model(reading)
    for path in exports:
        write_model(model, path, Path(reading.drawing.name).stem)
        counts = f'{len(model.rooms)} rooms and {len(model.doors)} doors'
        common.say(f'wrote {path}: {counts}', json_path)


def _checked(out: Path, drawing: Path) -> Path:
    """Return the path of the plot; raise ConfigError if an output path is invalid."""
    from fpnet_core.drawings.plan_files import picture_path
    from fpnet_core.io.maps import YAML_SUFFIXES

    if out.suffix.lower() not in YAML_SUFFIXES:
        raise ConfigError(f'--out {out}: expected a YAML file, e.g. {out.with_suffix(".yaml")}')
    picture = picture_path(out)
    written = {path.resolve() for path in (out, out.with_suffix('.png'), picture)}
    if drawing.resolve() in written:
        raise ConfigError(
            f'--out {out} would overwrite the drawing {drawing}; write to another folder, e.g. '
            f'--out {Path("out") / out.name}'
        )
    return picture
