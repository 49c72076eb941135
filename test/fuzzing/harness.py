# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Readers on damaged files in worker processes, with limits of time and memory.

Memory is limited by RLIMIT_DATA, counted from what the worker holds before the first damaged
file: RLIMIT_AS counts address space that PyTorch and Open3D reserve and never touch. An audit hook
tells what a reader would execute.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
import logging
from multiprocessing import connection, get_context
import os
from pathlib import Path
import resource
import shutil
import sys
import tempfile
import time
import traceback
from typing import Any
import warnings
import zlib

import numpy as np

from fpnet_core.errors import FpnetError
from fuzzing.misbehaving import MISBEHAVING
from fuzzing.mutations import MARKER, damage_place
from fuzzing.readers import READERS, Reader

MEMORY_LIMIT_BYTES = 2 * 2**30
TIME_LIMIT_S = 10.0
"""Of processor time, which other programs on the machine do not spend."""

_WAIT_LIMIT_S = 300.0  # by the clock, for a reader that waits for something
_KNOWN = (*READERS, *MISBEHAVING.values())  # a worker finds its reader by the place in it
_PLACE_SHARE = 0.03  # of the inputs are no file, another kind of file, or none
_LONGEST_MESSAGE = 600  # characters, of an error that a person shall read
DRAWING_READER = 'fpnet_core.drawings.formats.worker'
_EXECUTING = (
    'os.system', 'os.exec', 'os.fork', 'os.forkpty', 'os.posix_spawn', 'os.spawn',
    'subprocess.Popen', 'pickle.find_class', 'socket.connect', 'urllib.Request', 'webbrowser.open',
)  # fmt: skip


class Outcome(StrEnum):
    """What became of one input; all but the first two are failures."""

    ACCEPTED = 'accepted'
    REFUSED = 'refused'
    UNCLEAR = 'unclear'  # refused with a message that is empty, endless or not printable
    EXCEPTION = 'exception'  # any other exception
    MEMORY = 'memory'
    EXECUTED = 'executed'
    TIMEOUT = 'timeout'
    CRASH = 'crash'


GOOD = (Outcome.ACCEPTED, Outcome.REFUSED)


@dataclass(frozen=True)
class Case:
    """Input ``index`` of a reader, the same for the same seed."""

    reader: Reader
    seed: int
    index: int

    @property
    def key(self) -> tuple[int, int, int]:
        """What travels to a worker: the reader's place, seed and index."""
        return _KNOWN.index(self.reader), self.seed, self.index


@dataclass(frozen=True)
class Result:
    """Outcome of one input: message or where it came from, processor time, growth of memory."""

    case: Case
    outcome: Outcome
    detail: str = ''
    seconds: float = 0.0
    grown_bytes: int = 0


def plan(readers: Sequence[Reader], count: int, seed: int) -> list[Case]:
    """Return ``count`` cases, evenly spread over the readers."""
    return [Case(readers[k % len(readers)], seed, k // len(readers)) for k in range(count)]


def fuzz(cases: Iterable[Case], workers: int = 1) -> Iterator[Result]:
    """Yield the result of each case as it comes; a worker that dies is replaced."""
    waiting = list(cases)[::-1]
    with tempfile.TemporaryDirectory() as scratch:
        pool: list[_Worker] = []
        try:
            while waiting or any(worker.case for worker in pool):
                while waiting and len(pool) < workers:
                    pool.append(_Worker(Path(scratch)))
                for worker in pool:
                    if worker.case is None and waiting:
                        worker.start(waiting.pop())
                connection.wait([worker.pipe for worker in pool if worker.case], timeout=0.5)
                for worker in list(pool):
                    result = worker.poll()
                    if result is not None:
                        yield result
                    if worker.is_dead:
                        pool.remove(worker)
        finally:
            for worker in pool:
                worker.stop()


def make_input(case: Case, valid: Path, folder: Path) -> Path:
    """Copy the reader's valid input into ``folder``, damage it, and return what is to be read."""
    rng = np.random.default_rng([case.seed, zlib.crc32(_slug(case.reader).encode()), case.index])
    shutil.copytree(valid.parent, folder, symlinks=True)
    path = folder / valid.name if valid.name else folder
    if rng.random() < _PLACE_SHARE:
        files = sorted(entry for entry in folder.rglob('*') if entry.is_file())
        damage_place(files[rng.integers(len(files))], rng)
    else:
        case.reader.damage(folder, rng)
    return path


class _Worker:
    """The parent's side of one process."""

    def __init__(self, scratch: Path) -> None:
        context = get_context('spawn')
        self.pipe, far = context.Pipe()
        folder = Path(tempfile.mkdtemp(dir=scratch))
        self._process = context.Process(target=_serve, args=(far, folder), daemon=True)
        self._process.start()
        far.close()
        self.case: Case | None = None
        self.is_dead = False
        self._deadline = self._cpu_limit_s = 0.0

    def start(self, case: Case) -> None:
        self.case = case
        self._deadline = time.monotonic() + _WAIT_LIMIT_S
        self._cpu_limit_s = float('inf')  # imports, and compiling on first use
        self.pipe.send(case.key)

    def poll(self) -> Result | None:
        """Return the result if there is one; the worker is dead after a crash or timeout."""
        case = self.case
        if case is None:
            return None
        try:
            while self.pipe.poll():
                answer = self.pipe.recv()
                if answer is None:  # the valid input was read, now comes the damaged one
                    self._cpu_limit_s = self._cpu_s() + TIME_LIMIT_S
                    continue
                if isinstance(answer, str):
                    raise RuntimeError(f'no input {case.index} of {case.reader.name}: {answer}')
                self.case = None
                return Result(case, *answer)
        except (EOFError, OSError):
            self.stop()
            return Result(case, Outcome.CRASH, f'exit code {self._process.exitcode}')
        if time.monotonic() > self._deadline or self._cpu_s() > self._cpu_limit_s:
            self.stop()
            return Result(case, Outcome.TIMEOUT, f'more than {TIME_LIMIT_S:g} s', TIME_LIMIT_S)
        return None

    def _cpu_s(self) -> float:
        """Return the processor time that the process has taken."""
        stat = Path(f'/proc/{self._process.pid}/stat').read_text(encoding='ascii')
        user, system = stat.rpartition(')')[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf('SC_CLK_TCK')

    def stop(self) -> None:
        self.is_dead, self.case = True, None
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _serve(pipe: connection.Connection, scratch: Path) -> None:
    """Read damaged files until the parent goes away."""
    os.chdir(scratch)
    logging.disable()
    warnings.simplefilter('ignore')
    null = os.open(os.devnull, os.O_RDWR)
    for descriptor in (1, 2):  # Open3D and libtiff print
        os.dup2(null, descriptor)
    heard: list[str] = []
    sys.addaudithook(
        lambda event, what: (
            heard.append(event) if event in _EXECUTING and not _is_reader(event, what) else None
        )
    )
    valid: dict[str, Path] = {}
    try:
        while True:
            number, seed, index = pipe.recv()
            case = Case(_KNOWN[number], seed, index)
            slug = _slug(case.reader)
            try:
                if slug not in valid:
                    valid[slug] = _written(case.reader, scratch / 'valid' / slug)
                path = make_input(case, valid[slug], scratch / 'case')
            except Exception:
                pipe.send(traceback.format_exc())
                return
            pipe.send(None)
            pipe.send(_outcome(case.reader, path, heard))
            shutil.rmtree(scratch / 'case')
    except EOFError:
        return


def _is_reader(event: str, what: tuple[Any, ...]) -> bool:
    """Tell whether a process is the one, with limits of its own, that reads vector drawings."""
    return event == 'subprocess.Popen' and what[1][:3] == [sys.executable, '-m', DRAWING_READER]


def _written(reader: Reader, folder: Path) -> Path:
    """Write a valid input and read it, which imports and compiles all that is needed."""
    folder.mkdir(parents=True)
    path = reader.write(folder)
    reader.read(path)
    return path if path != folder else path / ''


def _outcome(reader: Reader, path: Path, heard: list[str]) -> tuple[Outcome, str, float, int]:
    heard.clear()
    Path('/proc/self/clear_refs').write_text('5', encoding='ascii')  # the peak starts anew
    before, started = _memory('VmRSS'), time.process_time()
    with _limited_memory():
        error = _attempt(reader, path)
        outcome, detail = _classify(error)
    seconds, grown = time.process_time() - started, _memory('VmHWM') - before
    if heard or Path(MARKER).exists():
        outcome, detail = Outcome.EXECUTED, ', '.join(heard) or MARKER
        Path(MARKER).unlink(missing_ok=True)
    elif grown > MEMORY_LIMIT_BYTES:
        outcome, detail = Outcome.MEMORY, f'{grown / 2**20:.0f} MiB'
    return outcome, detail, seconds, grown


def _attempt(reader: Reader, path: Path) -> BaseException | None:
    try:
        reader.read(path)
    except BaseException as error:
        return error
    return None


def _classify(error: BaseException | None) -> tuple[Outcome, str]:
    if error is None:
        return Outcome.ACCEPTED, ''
    if any(isinstance(link, MemoryError) and not _is_reserve(link) for link in _chain(error)):
        return Outcome.MEMORY, f'{type(error).__name__}: {str(error)[:200]}'
    if not isinstance(error, FpnetError):
        return Outcome.EXCEPTION, f'{type(error).__name__}: {str(error)[:200]}{_origin(error)}'
    message = ' '.join(str(error).split())
    is_clear = 0 < len(message) <= _LONGEST_MESSAGE and message.isprintable()
    return Outcome.REFUSED if is_clear else Outcome.UNCLEAR, message[:400]


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an error and what it was raised upon, ``from None`` or not."""
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _is_reserve(error: BaseException) -> bool:
    """Tell whether a read of more than the file has was refused: it would reserve, not fill."""
    frames = [frame.name for frame in traceback.extract_tb(error.__traceback__)]
    return frames[-1:] == ['read_exact']  # of rosbags


def _origin(error: BaseException) -> str:
    """Return the last lines of this project that an exception went through."""
    lines, trace = [], error.__traceback__
    while trace is not None:
        name = trace.tb_frame.f_code.co_filename
        if 'fpnet_core' in name or 'fpnet_lab' in name:
            lines.append(f'{Path(name).name}:{trace.tb_lineno}')
        trace = trace.tb_next
    return f' at {" ".join(lines[-3:])}' if lines else ''


class _limited_memory:
    """Let allocations of more than the limit fail, counted from now."""

    def __enter__(self) -> None:
        self._before = resource.getrlimit(resource.RLIMIT_DATA)
        limit = _memory('VmData') + MEMORY_LIMIT_BYTES
        resource.setrlimit(resource.RLIMIT_DATA, (limit, self._before[1]))

    def __exit__(self, *_: Any) -> None:
        resource.setrlimit(resource.RLIMIT_DATA, self._before)


def _memory(field: str) -> int:
    for line in Path('/proc/self/status').read_text(encoding='ascii').splitlines():
        if line.startswith(f'{field}:'):
            return 1024 * int(line.split()[1])
    raise LookupError(field)


def _slug(reader: Reader) -> str:
    return ''.join(c if c.isalnum() else '_' for c in f'{reader.group} {reader.name}')
