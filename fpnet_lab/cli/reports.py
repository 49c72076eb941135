# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports of benchmarks as JSON that says how it was made."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fpnet_core.cli import common
from fpnet_lab.provenance import Provenance

_begun: list[Provenance] = []


def begin() -> None:
    """Note what is run, and of which commit, before anybody commits another one."""
    _begun[:] = [Provenance.now()]


def write_report(path: Path | None, report: dict[str, Any]) -> None:
    """Write ``--json`` of ``fpnet bench`` where it is asked for, with what ``begin`` noted."""
    made = _begun[0] if _begun else Provenance.now()
    common.write_json(path, made.in_report(report))


def percent(share: float | None) -> str:
    """Return a share in per cent, ``-`` where there is none."""
    return '-' if share is None else f'{100.0 * share:.1f}'
