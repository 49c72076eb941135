# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Sandboxed reader of vector drawings: a subprocess with limits, as files may be malicious.

The process has limited memory and processor time; it may write no file, start no program and
open no connection. Its result comes back as plain arrays.
"""

from __future__ import annotations

from dataclasses import asdict
import importlib
import io
import json
import os
from pathlib import Path
import resource
import subprocess
import sys
from typing import Any, BinaryIO

import numpy as np

from fpnet_core.drawings.formats.messages import detail_of
from fpnet_core.drawings.model import model_from_json, model_to_json
from fpnet_core.drawings.types import (
    Drawing,
    DrawingScale,
    Label,
    ReadOptions,
    ScaleSource,
    Strokes,
)
from fpnet_core.errors import MapFormatError

MEMORY_BYTES = 1_600 * 2**20
"""Numerical: memory of the subprocess."""
CPU_S = 15
"""Numerical: processor time of the subprocess [s]."""

_WAIT_S = 120.0  # numerical: wall clock time of the subprocess on a busy machine
_REFUSED = 3  # given: exit status with an error message on standard output
_RECURSION = 8_000  # numerical: recursion limit; each nested group takes a few calls
_FORBIDDEN = (
    'os.system', 'os.exec', 'os.fork', 'os.forkpty', 'os.posix_spawn', 'os.spawn',
    'subprocess.Popen', 'socket.connect', 'socket.getaddrinfo', 'socket.bind', 'urllib.Request',
    'webbrowser.open', 'os.remove', 'os.rename', 'os.mkdir',
)  # fmt: skip
_STROKES = ('ends', 'width', 'colour', 'path', 'is_curve', 'layer')


def read_apart(path: Path, kind: str, options: ReadOptions) -> Drawing:
    """
    Return a drawing, read by a subprocess.

    Raises
    ------
    MapFormatError
        If the reader rejects it, exceeds its limits or crashes.
    """
    request = json.dumps({
        'path': str(path.absolute()), 'kind': kind, 'options': asdict(options), 'cpu_s': CPU_S,
    })  # fmt: skip
    root = str(Path(__file__).resolve().parents[3])
    places = [root, *filter(None, [os.environ.get('PYTHONPATH')])]
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(places), 'OMP_NUM_THREADS': '1'}
    try:
        done = subprocess.run(  # noqa: S603
            [sys.executable, '-m', 'fpnet_core.drawings.formats.worker', request],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_WAIT_S,
            env=environment,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise MapFormatError(_too_long(path)) from None
    if done.returncode == 0:
        return unpack(done.stdout)
    raise MapFormatError(_reason(path, done))


def _reason(path: Path, done: subprocess.CompletedProcess[bytes]) -> str:
    """Return the error message for a process that ended without a drawing."""
    if done.returncode == _REFUSED:
        return done.stdout.decode('utf-8', errors='replace')
    if done.returncode in (-24, -9):  # SIGXCPU, SIGKILL at the hard limit
        return _too_long(path)
    return (
        f'{path.name} cannot be read: it is damaged, or takes more than '
        f'{MEMORY_BYTES // 2**20} MB of memory; export the storey again without hatches'
    )


def _too_long(path: Path) -> str:
    return (
        f'{path.name} takes more than {CPU_S} s to read: expected a floorplan of one storey; '
        'export it without hatches, furniture and other storeys'
    )


def main() -> None:
    """Read the drawing requested on the command line and write it to standard output."""
    out = os.fdopen(os.dup(1), 'wb')
    null = os.open(os.devnull, os.O_RDWR)
    for descriptor in (1, 2):  # libraries print to them
        os.dup2(null, descriptor)
    request = json.loads(sys.argv[1])
    _limit(request['cpu_s'])
    sys.exit(_answer(request, out))


def _limit(cpu_s: int) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s + 2))
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _forbid(event: str, _: Any) -> None:
    if event in _FORBIDDEN:
        raise PermissionError(f'blocked while reading a drawing: {event}')


def _answer(request: dict[str, Any], out: BinaryIO) -> int:
    """Write the drawing or an error message; return the exit status."""
    options = ReadOptions(**{key: _tuples(value) for key, value in request['options'].items()})
    try:
        _load_and_restrict(request['kind'])
        drawing = read_here(Path(request['path']), request['kind'], options)
        data, status = pack(drawing), 0
    except MapFormatError as error:
        data, status = str(error).encode(), _REFUSED
    except MemoryError:
        data, status = b'', 1
    except Exception as error:  # libraries raise many exception types on damaged files
        data, status = _damaged(request, error).encode(), _REFUSED
    out.write(data)
    out.close()
    return status


def _damaged(request: dict[str, Any], error: Exception) -> str:
    kind, name = request['kind'].upper(), Path(request['path']).name
    detail = f'{type(error).__name__}: {detail_of(error)}'
    return f'{name} is a damaged {kind} file ({detail}); export it again'


def _tuples(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _load_and_restrict(kind: str) -> None:
    """Import the reader of a format, then block all operations that it does not need."""
    importlib.import_module(f'fpnet_core.drawings.formats.{kind}').load_libraries()
    sys.addaudithook(_forbid)
    sys.setrecursionlimit(_RECURSION)


def read_here(path: Path, kind: str, options: ReadOptions) -> Drawing:
    """Return a drawing, read in this process without limits; for trusted files only."""
    from fpnet_core.drawings.formats.vector import drawing_of

    module = importlib.import_module(f'fpnet_core.drawings.formats.{kind}')
    page = getattr(module, f'read_{kind}')(path, options)
    return drawing_of(page, path.name, kind, options)


def pack(drawing: Drawing) -> bytes:
    """Return a drawing serialized as an NPZ archive."""
    arrays: dict[str, Any] = {'pixels': drawing.pixels, 'A_pixel_image': drawing.A_pixel_image}
    if drawing.strokes is not None:
        arrays.update({name: getattr(drawing.strokes, name) for name in _STROKES})
    facts = {
        'name': drawing.name,
        'format': drawing.format,
        'layers': drawing.strokes.layers if drawing.strokes is not None else None,
        'labels': [(label.text, label.box) for label in drawing.labels],
        'scale': asdict(drawing.scale) if drawing.scale is not None else None,
        'paper_m': drawing.paper_m,
        'door_px': drawing.door_px,
        'notes': drawing.notes,
        'doubts': drawing.doubts,
        'model': model_to_json(drawing.model) if drawing.model is not None else None,
    }
    arrays['facts'] = np.frombuffer(json.dumps(facts).encode(), dtype=np.uint8)
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def unpack(data: bytes) -> Drawing:
    """Return the drawing from the output of :func:`pack`."""
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    facts = json.loads(arrays.pop('facts').tobytes())
    layers, scale, model = (facts.pop(key) for key in ('layers', 'scale', 'model'))
    strokes = None
    if layers is not None:
        strokes = Strokes(**{name: arrays[name] for name in _STROKES}, layers=tuple(layers))
    if scale is not None:
        scale = DrawingScale(**{**scale, 'source': ScaleSource(scale['source'])})
    return Drawing(
        pixels=arrays['pixels'],
        strokes=strokes,
        labels=tuple(Label(text, tuple(box)) for text, box in facts.pop('labels')),
        scale=scale,
        A_pixel_image=arrays['A_pixel_image'],
        model=model_from_json(model) if model is not None else None,
        **{key: _tuples(value) for key, value in facts.items()},
    )


if __name__ == '__main__':
    main()
