# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Child processes for nodes, which never outlive their parent.

Used by the demo and by the tests; imports no ROS. Every child leads a process group, so that
Ctrl-C reaches only the parent, which then ends the children in order; if the parent is killed, the
kernel ends them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import ctypes
from dataclasses import dataclass
import json
import os
from pathlib import Path
import random
import signal
import socket
import subprocess
import sys
import time
from typing import Any, Self

from fpnet_core.errors import FpnetError
from fpnet_ros.wiring import PROFILE, PROFILE_VARIABLE, has_shared_memory

PACKAGE = 'fpnet_ros'

_ROOT = Path(__file__).resolve().parents[2]
_PR_SET_PDEATHSIG = 1  # given: linux/prctl.h
_LIBC = ctypes.CDLL(None)
# Chosen, not measured:
_GRACE_S = 15.0  # a node finishes its update and writes its run folder
_LOG_TAIL_LINES = 12

# Domains above 101 use ephemeral ports of Linux. The ports of domain d start at 7400 + 250 d:
# multicast discovery at offset 0, unicast discovery of the first participant at offset 10.
_DOMAINS = range(1, 101)
_FIRST_PORT, _PORTS_PER_DOMAIN, _PARTICIPANT_PORT = 7400, 250, 10  # given


class NodeDiedError(FpnetError):
    """Unexpected end of a process; the message has its last log lines."""


def free_domain_id() -> int:
    """Return a ROS domain without participants on this machine."""
    candidates = list(_DOMAINS)
    random.SystemRandom().shuffle(candidates)
    for domain_id in candidates:
        first = _FIRST_PORT + _PORTS_PER_DOMAIN * domain_id
        if _is_free(first) and _is_free(first + _PARTICIPANT_PORT):
            return domain_id
    raise FpnetError('every ROS domain is in use; end stray ROS processes')


def _is_free(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(('', port))
        except OSError:
            return False
    return True


def private_environment(domain_id: int) -> dict[str, str]:
    """
    Return the environment for nodes that communicate on this machine only, in their own domain.

    It has the shared-memory profile for large clouds if /dev/shm has room for it.
    """
    environment = dict(os.environ)
    environment['ROS_DOMAIN_ID'] = str(domain_id)
    environment['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    environment['PYTHONUNBUFFERED'] = '1'
    search = [str(_ROOT), *environment.get('PYTHONPATH', '').split(os.pathsep)]
    environment['PYTHONPATH'] = os.pathsep.join(filter(None, search))
    if has_shared_memory():
        environment[PROFILE_VARIABLE] = str(share_file(PROFILE))
    return environment


def share_file(name: str) -> Path:
    """Return the path of a shared file, for example ``config/fpnet.yaml``, in a checkout first."""
    prefixes = [*os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix]
    candidates = [Path(prefix) / 'share' / PACKAGE / name for prefix in prefixes if prefix]
    for path in [_ROOT / name, *candidates]:
        if path.is_file():
            return path
    raise FpnetError(f'{name} is not installed; install {PACKAGE} again')


def node_command(name: str) -> list[str]:
    """Return the command that runs a node, by the name of its executable."""
    words = [__package__] if name == 'replay' else [f'{PACKAGE}.executables', name]
    return [sys.executable, '-m', *words]


def ros_arguments(
    parameters: Mapping[str, Any] | None = None, remappings: Mapping[str, str] | None = None
) -> list[str]:
    """Return command-line arguments; values are JSON, so that YAML keeps their types."""
    arguments = ['--ros-args']
    for name, value in (parameters or {}).items():
        arguments += ['-p', f'{name}:={json.dumps(value)}']
    for old, new in (remappings or {}).items():
        arguments += ['-r', f'{old}:={new}']
    return arguments


@dataclass(frozen=True)
class Child:
    """A running node and the file of its output."""

    name: str
    process: subprocess.Popen[bytes]
    log: Path

    def log_tail(self) -> str:
        """Return the last lines that the process wrote."""
        lines = self.log.read_text(encoding='utf-8', errors='replace').splitlines()
        return '\n'.join(lines[-_LOG_TAIL_LINES:])


class ProcessGroup:
    """
    Child processes that end with this context, in reverse order of their start.

    Parameters
    ----------
    log_dir
        Folder for ``<name>.log`` of every child.
    environment
        Environment of all children.
    """

    def __init__(self, log_dir: Path, environment: Mapping[str, str]) -> None:
        self._log_dir = log_dir
        self._environment = dict(environment)
        self._children: list[Child] = []
        log_dir.mkdir(parents=True, exist_ok=True)

    def __enter__(self) -> Self:
        """Return the group; nothing runs yet."""
        return self

    def __exit__(self, *_: object) -> None:
        """End every child."""
        self.stop()

    def start(self, name: str, command: Sequence[str]) -> Child:
        """Start a child whose standard output and error go to ``<name>.log``."""
        log = self._log_dir / f'{name}.log'
        with log.open('wb') as output:
            # The command is built by this package from its own names and the caller's paths.
            process = subprocess.Popen(  # noqa: S603
                list(command),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env=self._environment,
                start_new_session=True,
                preexec_fn=_end_with_parent,  # noqa: PLW1509 - a system call that takes no lock
            )
        child = Child(name, process, log)
        self._children.append(child)
        return child

    def check(self, may_end: Sequence[Child] = ()) -> None:
        """
        Raise NodeDiedError if a child has ended.

        Children in ``may_end`` may end with exit status 0.
        """
        for child in self._children:
            status = child.process.poll()
            if status is None or (status == 0 and child in may_end):
                continue
            raise NodeDiedError(
                f'{child.name} ended with status {status}; its last lines ({child.log}):\n'
                f'{child.log_tail()}'
            )

    def stop(self) -> None:
        """End every child with SIGTERM, and after a grace period with SIGKILL."""
        running = [child for child in reversed(self._children) if child.process.poll() is None]
        for child in running:
            _signal_group(child, signal.SIGTERM)
        deadline = time.monotonic() + _GRACE_S
        for child in running:
            try:
                child.process.wait(timeout=max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                _signal_group(child, signal.SIGKILL)
                child.process.wait()
        self._children.clear()


def _end_with_parent() -> None:
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def _signal_group(child: Child, number: signal.Signals) -> None:
    try:
        os.killpg(child.process.pid, number)
    except ProcessLookupError:
        return  # it has ended meanwhile
