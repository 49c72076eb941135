# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports of benchmarks as JSON that says how it was made."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from fpnet_core.cli import common
from fpnet_lab.provenance import Provenance


def write_report(path: Path, report: dict[str, Any]) -> None:
    """Write ``--json`` of ``fpnet bench``, with the commit that was there when it began."""
    context = click.get_current_context(silent=True)
    made = None if context is None else context.find_object(Provenance)
    common.write_json(path, (made or Provenance.now()).in_report(report))
