# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What commands share that say whether a drawing will serve as a floorplan."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fpnet.cli import common
from fpnet_core.errors import ConfigError, MapFormatError

if TYPE_CHECKING:
    from fpnet.plan_check.verdict import PlanVerdict
    from fpnet_core.config import FpnetConfig
    from fpnet_core.drawings.types import Reading
    from fpnet_core.scoring.invocation import Invocation

AcceptOption = Annotated[
    str | None,
    typer.Option(
        '--accept',
        metavar='REASON',
        help="Take the plan whatever speaks against it, and say why: 'it is a hall'.",
    ),
]


def accepting(reading: Reading, reason: str | None) -> Reading:
    """Return a reading with why its user accepts it; ConfigError for an empty reason."""
    if reason is None:
        return reading
    words = ' '.join(reason.split())
    if not words:
        raise ConfigError("--accept: expected a reason, as --accept 'it is a hall'")
    return replace(reading, accepted=words)


def verdict_on(
    reading: Reading, tree: FpnetConfig, invocation: Invocation, picture: str = ''
) -> PlanVerdict:
    """Return whether a plan will serve; ``picture`` shows how it was read."""
    from fpnet.plan_check.verdict import verdict_of
    from fpnet_core.segmentation import told_scale

    segmentation = reading.segmented(tree.segmentation)
    told = told_scale(reading.grid, segmentation, tree.segmentation)
    return verdict_of(reading, segmentation, invocation, told, picture)


@contextmanager
def refusal_as_json(invocation: Invocation, json_path: Path | None) -> Iterator[None]:
    """Write why a drawing could not be read before the error goes on, for who asked for JSON."""
    try:
        yield
    except MapFormatError as error:
        from fpnet.plan_check.verdict import unreadable

        common.write_json(json_path, {'verdict': unreadable(error, invocation).as_json()})
        raise
