# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The ``fpnet`` command: one module per subcommand, imported only when it is called.

To add a subcommand, write ``fpnet/cli/<name>.py`` and list it in ``COMMANDS``. Subcommands that
no robot needs go to ``fpnet_lab.cli``, which is found by its entry point in the group
``fpnet.commands``; other packages can add subcommands the same way. The module
exports either a function ``command`` or, for a group like ``fpnet simulate recording``, a
``typer.Typer`` called ``app``::

    from typing import Annotated
    import typer
    from fpnet.cli import common

    def command(
        input_path: Annotated[Path, typer.Argument(metavar='INPUT', help='Floorplan image.')],
        config: common.ConfigOption = None,
        settings: common.SetOption = None,
        seed: common.SeedOption = None,
        json_path: common.JsonOption = None,
    ) -> None:
        \"\"\"
        Describe in one line what the user gets.

        Example: fpnet NAME plan.png --json out.json
        \"\"\"
        tree = common.load(config, settings, seed)
        from fpnet_core.segmentation import segment_floorplan   # heavy imports go in here

``--config``, ``--set``, ``--out``, ``--seed``, ``--device`` and ``--json`` mean the same
everywhere: take their types from :mod:`fpnet.cli.common`, which also has tables and
JSON output. A subcommand returns on success, raises an FpnetError for bad input (one line, exit
status 1), or raises ``typer.Exit(code)`` if it ran and its result is negative.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import entry_points
import os
import signal
import sys
from typing import Any

import typer

from fpnet_core.errors import FpnetError, said_of_system
from fpnet_core.freed_memory import keep_freed_memory
from fpnet_core.printable import printable

INTERRUPTED = 130
"""Given: exit status after Ctrl-C, as shells define it."""

_SOON_S = 0.05  # numerical

VERBOSE = ('--verbose', '-v')
ENTRY_POINTS = 'fpnet.commands'
"""Entry-point group; each entry maps names to :class:`Subcommand`."""


@dataclass(frozen=True)
class Subcommand:
    """
    Module to import when the subcommand is called, and its line in ``fpnet --help``.

    ``extra`` is the pip extra with the libraries that it needs in addition to the core's.
    """

    module: str
    summary: str
    extra: str = 'report'


COMMANDS = {
    'align': Subcommand(
        'fpnet.cli.align', 'Align a robot map with a floorplan, and export both ways.'
    ),
    'check-plan': Subcommand(
        'fpnet.cli.check_plan', 'Check whether a floorplan is usable before a robot drives.'
    ),
    'diff': Subcommand(
        'fpnet.cli.diff', 'Find where a drawing and a recording or robot map differ.'
    ),
    'doctor': Subcommand('fpnet.cli.doctor', 'Find faults of a recording or a running robot.'),
    'library': Subcommand(
        'fpnet.cli.library', 'Find the floorplan of the right building among many.'
    ),
    'localize': Subcommand('fpnet.cli.localize', 'Localize a recording on a floorplan, offline.'),
    'match': Subcommand(
        'fpnet.cli.match', 'Find the transform between a floorplan and a robot map.'
    ),
    'plan': Subcommand(
        'fpnet.cli.plan', 'Convert a drawing (PDF, DXF, scan, photo) to a floorplan.'
    ),
    'segment': Subcommand(
        'fpnet.cli.segment', 'Segment a plan, map or recording into rooms and doors.'
    ),
    'site': Subcommand(
        'fpnet.cli.site', 'Check the storeys of a site: plans, links, and look-alikes.'
    ),
    'view': Subcommand(
        'fpnet.cli.view',
        'Show a run live, or replay a recorded one, in a browser.',
    ),
}
"""Subcommands of this package."""


def installed_commands() -> dict[str, Subcommand]:
    """Return the subcommands of this and other installed packages, sorted by name."""
    found = dict(COMMANDS)
    for entry in entry_points(group=ENTRY_POINTS):
        with suppress(ModuleNotFoundError):  # the lab package is optional
            found.update(entry.load())
    return dict(sorted(found.items()))


def build_app(subcommand: str | None) -> typer.Typer:
    """
    Return the Typer app with ``subcommand`` loaded.

    The others appear by name and summary only, so that ``fpnet --help`` imports none of them.
    """
    app = typer.Typer(
        name='fpnet',
        help='Localize a robot on a floorplan with lidar.',
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={'help_option_names': ['-h', '--help']},
    )
    app.callback()(_options)
    for name, entry in installed_commands().items():
        if name != subcommand:
            app.command(name, help=entry.summary)(_not_loaded)
            continue
        module = import_module(entry.module)
        if hasattr(module, 'app'):
            app.add_typer(module.app, name=name)
        else:
            app.command(name)(module.command)
    return app


def main(arguments: Sequence[str] | None = None) -> None:
    """
    Run ``fpnet``; the console entry point.

    Always raises SystemExit: 0 success, 1 bad input or negative result, 2 wrong usage,
    3 no answer, 130 Ctrl-C.
    """
    # NumPy reads this when imported. BLAS threads slow down small matrix products.
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    arguments = _verbose_first(sys.argv[1:] if arguments is None else arguments)
    with _noted_interrupts() as interrupts:
        try:
            _run(arguments)
        except BaseException as ended:  # Ctrl-C may surface as ImportError or Abort
            if interrupts or _is_interrupt(ended):
                raise SystemExit(INTERRUPTED) from None
            raise


def _run(arguments: Sequence[str]) -> None:
    subcommand = _subcommand(arguments or _words_to_complete())
    try:
        command = typer.main.get_command(build_app(subcommand))
        if subcommand is not None:
            keep_freed_memory()
            import_module('fpnet.cli.outputs').look_first(command)
        command(args=arguments, prog_name='fpnet')
    except ModuleNotFoundError as error:
        _fail_for_missing(subcommand, error)
    except FpnetError as error:
        _fail(' '.join(str(error).split()))
    except OSError as error:
        _fail(said_of_system(error))


@contextmanager
def _noted_interrupts() -> Iterator[list[int]]:
    """
    Yield a list that records every Ctrl-C: a library's bare ``except`` may discard one.

    An interrupt that Python reports as unraisable is repeated.
    """
    interrupts: list[int] = []

    def note(number: int, frame: Any) -> None:
        interrupts.append(number)
        signal.default_int_handler(number, frame)

    hook, sys.unraisablehook = sys.unraisablehook, _interrupt_again
    handler = signal.getsignal(signal.SIGINT)
    is_ours = handler is signal.default_int_handler
    if is_ours:
        with suppress(ValueError):  # only the main thread may set handlers
            signal.signal(signal.SIGINT, note)
    try:
        yield interrupts
    finally:
        sys.unraisablehook = hook
        if signal.getsignal(signal.SIGINT) is note:
            signal.signal(signal.SIGINT, handler)


def _is_interrupt(ended: BaseException) -> bool:
    """Return whether it is a Ctrl-C, or the Abort that Typer raises for one."""
    why = ended.__context__
    is_abort = isinstance(why, typer.Abort) and isinstance(why.__cause__, KeyboardInterrupt)
    return is_abort or isinstance(ended, KeyboardInterrupt)


def _interrupt_again(lost: Any) -> None:
    """
    Repeat a Ctrl-C that was discarded while a compiled library called Python.

    It is delayed: an interrupt inside this function would be discarded as well.
    """
    if not issubclass(lost.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(lost)
        return
    import _thread
    import threading

    threading.Timer(_SOON_S, _thread.interrupt_main).start()


def _subcommand(words: Sequence[str]) -> str | None:
    # Options before the subcommand take no values, so the first bare word is the subcommand.
    return next((word for word in words if not word.startswith('-')), None)


def _verbose_first(words: Sequence[str]) -> list[str]:
    """Return the words with ``--verbose`` and ``-v`` moved before the subcommand."""
    end = words.index('--') if '--' in words else len(words)
    flags = [word for word in words[:end] if word in VERBOSE]
    return [*flags, *(word for word in words[:end] if word not in VERBOSE), *words[end:]]


def _words_to_complete() -> list[str]:
    """Return the words typed so far if a shell asks for completions, else an empty list."""
    if '_FPNET_COMPLETE' not in os.environ:
        return []
    # bash sets COMP_WORDS, zsh and fish set the other variable.
    typed = os.environ.get('COMP_WORDS') or os.environ.get('_TYPER_COMPLETE_ARGS', '')
    return typed.split()[1:]


def _fail_for_missing(subcommand: str | None, error: ModuleNotFoundError) -> None:
    """Name the pip extra of a missing library; re-raise for our own modules (a defect)."""
    entry = installed_commands().get(subcommand or '')
    if entry is None or (error.name or '').startswith('fpnet'):
        raise error
    _fail(
        f'{subcommand} needs {error.name}, which is not installed: '
        f"pip install 'fpnet_ros[{entry.extra}]'"
    )


def _fail(message: str) -> None:
    print(printable(f'fpnet: {message}'), file=sys.stderr)
    raise SystemExit(1)


def _not_loaded() -> None:
    raise AssertionError('a subcommand ran without being loaded')


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f'fpnet {version("fpnet_ros")}')
        raise typer.Exit


def _options(
    verbose: bool = typer.Option(
        False, *VERBOSE, help='Log details to stderr; also accepted after the subcommand.'
    ),
    version: bool = typer.Option(
        False, '--version', callback=_show_version, is_eager=True, help='Print the version.'
    ),
) -> None:
    import logging

    class PrintableFormatter(logging.Formatter):
        def format(self, record: logging.LogRecord) -> str:
            return printable(super().format(record))

    handler = logging.StreamHandler()
    handler.setFormatter(PrintableFormatter('%(levelname)s %(name)s: %(message)s'))
    level = logging.INFO if verbose else logging.WARNING
    logging.basicConfig(level=level, handlers=[handler])
