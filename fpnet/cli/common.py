# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Options, configuration, tables and JSON output shared by all subcommands.

:func:`reads_drawing` adds the options about a drawing to a command. They are defined and parsed
only here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
import functools
import inspect
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer

from fpnet_core.errors import ConfigError, FpnetError
from fpnet_core.printable import printable

if TYPE_CHECKING:
    from fpnet_core.config import FpnetConfig
    from fpnet_core.drawings.types import Reading, ReadOptions
    from fpnet_core.scoring.invocation import Invocation
    from fpnet_core.types import Cause


def complete_setting(incomplete: str) -> list[str]:
    """Return the completions of a partial ``--set`` value."""
    from fpnet_core.config import config_keys

    return [f'{key}=' for key in config_keys() if key.startswith(incomplete)]


def choice(name: str, words: Any, said: str) -> Any:
    """
    Return an option that accepts the values of a Literal.

    Typer supports Literal only from version 0.19 on.
    """
    known = get_args(words)

    def parse(word: str) -> str:
        if word in known:
            return word
        raise typer.BadParameter(f'{word!r} is not one of {", ".join(known)}')

    def complete(incomplete: str) -> list[str]:
        return [word for word in known if word.startswith(incomplete)]

    return typer.Option(
        name, parser=parse, metavar=f'[{"|".join(known)}]', help=said, autocompletion=complete
    )


ConfigOption = Annotated[
    Path | None,
    typer.Option('--config', metavar='FILE', help='Configuration YAML; default: built-in.'),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        '--set',
        metavar='KEY=VALUE',
        help='Override a configuration key, e.g. submap.resolution_m=0.1; repeatable.',
        autocompletion=complete_setting,
    ),
]
SubmapOption = Annotated[
    Path,
    typer.Option('--submap', metavar='FILE', help='Robot map: image, YAML or point cloud.'),
]
SubmapStoreyOption = Annotated[
    int | None,
    typer.Option('--submap-storey', min=1, help='Storey of a point cloud, 1 is the lowest.'),
]
OutOption = Annotated[
    Path | None, typer.Option('--out', metavar='DIR', help='Output folder, created if missing.')
]
SeedOption = Annotated[
    int | None, typer.Option('--seed', min=0, help='Seed of all random numbers.')
]
DeviceOption = Annotated[
    str,
    typer.Option('--device', metavar='NAME', help='Device of the network: cpu, cuda or cuda:N.'),
]
JsonOption = Annotated[
    Path | None,
    typer.Option('--json', metavar='FILE', help='Write the result as JSON; - for stdout.'),
]

REPORT_NAME = 'report.html'
"""File name of the report in the output folder."""

DEFAULT_PORT = 8123
"""Chosen: port of the live page."""

PortOption = Annotated[
    int,
    typer.Option(
        '--port', min=0, max=65535, help='Port of the live page on 127.0.0.1; 0: any free port.'
    ),
]

DRAWING_HELP = 'Floorplan drawing (PNG, JPEG, PDF, SVG, DXF, ...) or map_server YAML.'

FloorplanOption = Annotated[
    Path | None, typer.Option('--floorplan', metavar='F', help=DRAWING_HELP)
]
SiteOption = Annotated[
    Path | None,
    typer.Option(
        '--site',
        metavar='SITE',
        help='Site with several storeys instead of one floorplan: site.yaml, a folder of maps, '
        'or an Open-RMF *.building.yaml.',
    ),
]


@dataclass(frozen=True)
class DrawingOptions:
    """Command-line options about a drawing; each field has the name of its option."""

    resolution: Annotated[
        float | None,
        typer.Option('--resolution', min=1e-6, help='Metres per pixel of the drawing.'),
    ] = None
    length: Annotated[
        str | None,
        typer.Option(
            '--length',
            metavar='X1,Y1,X2,Y2=M',
            help='Scale from two points on the drawing in pixels and their distance in metres: '
            '120,80,520,80=6.0.',
        ),
    ] = None
    crop: Annotated[
        str | None,
        typer.Option(
            '--crop', metavar='L,T,R,B', help='Read only this part of the drawing, in pixels.'
        ),
    ] = None
    storey: Annotated[
        int | None,
        typer.Option(
            '--storey',
            min=1,
            help='Storey to use if a sheet or point cloud has several, from 1.',
        ),
    ] = None
    page: Annotated[
        int | None, typer.Option('--page', min=1, help='Page of a PDF or TIFF; storey of an IFC.')
    ] = None
    layer: Annotated[
        list[str] | None,
        typer.Option(
            '--layer', metavar='NAME', help='DXF, SVG or PDF layer with walls; repeatable.'
        ),
    ] = None
    mirrored: Annotated[
        bool, typer.Option('--mirrored', help='Flip the drawing: it is a mirror image.')
    ] = False

    def read(self, path: Path, tree: FpnetConfig) -> Reading:
        """Parse the drawing; flip it if ``--mirrored`` was given."""
        from fpnet_core.drawings.read import read_plan
        from fpnet_core.kernel_cache import is_filled

        check_input(path)
        if not is_filled():
            typer.echo('compiling for this processor: once, less than a minute', err=True)
        reading = read_plan(path, self.as_read_options(), tree)
        return reading.flipped() if self.mirrored else reading

    def as_read_options(self) -> ReadOptions:
        """Return the options for the parser; raise ConfigError if one is malformed."""
        from fpnet_core.drawings.types import ReadOptions

        return ReadOptions(
            self.resolution,
            None if self.length is None else parse_length(self.length),
            None if self.crop is None else parse_crop(self.crop),
            self.storey,
            self.page,
            tuple(self.layer or ()),
        )

    def invocation(self, command: Sequence[str], path: Path) -> Invocation:
        """Return the command line; ``command`` are the words before the drawing."""
        from fpnet_core.scoring.invocation import Invocation

        return Invocation(tuple(command), str(path), tuple(self.pairs()))

    def typed(
        self, command: Sequence[str], floorplan: Path | None, site: Path | None
    ) -> Invocation:
        """Return the command line with a floorplan or a site; ``command`` lacks its options."""
        if floorplan is not None:
            return self.invocation(('fpnet', *command, '--floorplan'), floorplan)
        return self.invocation(('fpnet', *command, '--site'), site or Path())

    def pairs(self) -> Iterator[tuple[str, str]]:
        """Yield the given options with their values."""
        for field in fields(self):
            value, option = getattr(self, field.name), f'--{field.name}'
            if value is True:
                yield option, ''
            elif value not in (None, False):
                yield from ((option, str(each)) for each in _listed(value))

    def refuse(self, why: str, *but: str) -> None:
        """Raise ConfigError with ``why`` for the first given option that is not in ``but``."""
        for option, _ in self.pairs():
            if option not in but:
                raise ConfigError(f'{option} {why}')


def _listed(value: Any) -> Sequence[Any]:
    return value if isinstance(value, list) else [value]


def reads_drawing(command: Callable[..., None]) -> Callable[..., None]:
    """
    Add the options of a drawing to a command, which receives them as one object, ``said``.

    They follow the command's required parameters.
    """
    own = inspect.signature(command, eval_str=True)
    hints = inspect.get_annotations(DrawingOptions, eval_str=True)
    options = [
        inspect.Parameter(
            field.name, inspect.Parameter.KEYWORD_ONLY, default=field.default,
            annotation=hints[field.name],
        )
        for field in fields(DrawingOptions)
    ]  # fmt: skip

    @functools.wraps(command)
    def wrapper(**values: Any) -> None:
        said = DrawingOptions(**{field.name: values.pop(field.name) for field in options_of})
        command(**values, said=said)

    options_of = fields(DrawingOptions)
    kept = [
        parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY)
        for name, parameter in own.parameters.items()
        if name != 'said'
    ]
    first = sum(parameter.default is inspect.Parameter.empty for parameter in kept)
    parameters = [*kept[:first], *options, *kept[first:]]
    wrapper.__annotations__ = {each.name: each.annotation for each in parameters}
    wrapper.__signature__ = own.replace(parameters=parameters)  # type: ignore[attr-defined]
    return wrapper


def parse_length(text: str) -> tuple[float, float, float, float, float]:
    """Parse ``120,80,520,80=6.0`` into five numbers; raise ConfigError if malformed."""
    places, _, metres = text.partition('=')
    numbers = _numbers(places, 4)
    length = _numbers(metres.removesuffix('m'), 1)
    if numbers is None or length is None:
        raise ConfigError(f'--length {text}: expected X1,Y1,X2,Y2=METRES, e.g. 120,80,520,80=6.0')
    x1, y1, x2, y2 = numbers
    return x1, y1, x2, y2, length[0]


def parse_crop(text: str) -> tuple[int, int, int, int]:
    """Parse ``40,60,900,700`` into four numbers; raise ConfigError if malformed."""
    numbers = _numbers(text, 4)
    if numbers is None:
        raise ConfigError(f'--crop {text}: expected LEFT,TOP,RIGHT,BOTTOM, e.g. 40,60,900,700')
    left, top, right, bottom = map(round, numbers)
    return left, top, right, bottom


def _numbers(text: str, count: int) -> list[float] | None:
    """Return ``count`` finite numbers separated by commas; None if ``text`` is malformed."""
    try:
        numbers = [float(word) for word in text.split(',')]
    except ValueError:
        return None
    return numbers if len(numbers) == count and all(map(math.isfinite, numbers)) else None


def load(
    config: Path | None, settings: Sequence[str] | None = None, seed: int | None = None
) -> FpnetConfig:
    """Return the configuration from ``--config``, ``--set`` and ``--seed``; later ones win."""
    from fpnet_core.config import load_config

    overrides = parse_settings(settings or ())
    if seed is not None:
        overrides['seed'] = seed
    return load_config(config, overrides)


def parse_settings(settings: Sequence[str]) -> dict[str, Any]:
    """Parse ``['submap.resolution_m=0.1']`` into ``{'submap.resolution_m': 0.1}``."""
    from fpnet_core.plain_yaml import parse_yaml

    overrides: dict[str, Any] = {}
    for setting in settings:
        key, equals, text = setting.partition('=')
        if not (equals and all(key.split('.'))):
            raise ConfigError(f'--set {setting}: expected KEY=VALUE, e.g. submap.resolution_m=0.1')
        try:
            overrides[key] = parse_yaml(text)
        except ValueError:
            raise ConfigError(f'--set {setting}: {text!r} is not a YAML value') from None
    return overrides


def write_json(path: Path | None, result: Mapping[str, Any]) -> None:
    """Write ``result`` to ``path``, creating its folder; ``-`` is stdout, None writes nothing."""
    if path is None:
        return
    text = json.dumps(result, indent=2, allow_nan=False)
    if str(path) == '-':
        typer.echo(text)
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text + '\n', encoding='utf-8')


def show_table(
    titles: Sequence[str],
    rows: Iterable[Sequence[str]],
    json_path: Path | None,
    title: str | None = None,
    width: int | None = None,
) -> None:
    """Print a table of strings, unless ``--json -`` uses stdout."""
    from rich.console import Console
    from rich.table import Column, Table

    if str(json_path) == '-':
        return
    first, *others = titles
    numbers = (Column(name, justify='right') for name in others)
    table = Table(Column(first, no_wrap=True), *numbers, title=title)
    for row in rows:
        table.add_row(*map(printable, row))
    Console(width=width, markup=False).print(table)  # [m] is a unit, not markup


def say(text: str, json_path: Path | None) -> None:
    """Print a message to stdout, or to stderr if ``--json -`` uses stdout."""
    typer.echo(printable(text), err=str(json_path) == '-')


def typed_settings(config: Path | None, settings: Sequence[str] | None) -> list[str]:
    """Return ``--config`` and ``--set`` as given on the command line."""
    given = [] if config is None else ['--config', str(config)]
    for setting in settings or ():
        given += ['--set', setting]
    return given


def say_reading(reading: Reading, json_path: Path | None) -> None:
    """Print the estimated scale, notes and warnings of a parsed drawing, if there are any."""
    from fpnet_core.drawings.wording import said_of_scale

    if not reading.scale.is_known:
        say(f'{reading.drawing.name}: {said_of_scale(reading.scale)}', json_path)
    for note in reading.notes:
        say(note, json_path)
    if reading.accepted:
        say(f'{reading.drawing.name}: accepted: {reading.accepted}', json_path)
        return
    for doubt in reading.doubts:
        say(f'warning: parse of {reading.drawing.name}: {doubt}', json_path)


def say_causes(causes: Sequence[Cause], json_path: Path | None) -> None:
    """Print the likely causes of a failure and the next commands, most likely first."""
    if causes:
        say('likely causes and next steps:', json_path)
    for number, cause in enumerate(causes, start=1):
        say(f'{number}. {cause.said}\n   next: {cause.next}', json_path)


def check_input(path: Path) -> Path:
    """Return ``path``; raise FpnetError if it does not exist."""
    if not path.exists():
        raise FpnetError(f'{path} does not exist; give an existing file or folder')
    return path
