# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Verdict on a drawing and the option ``--accept``, shared by several commands."""

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
        help="Use the plan despite its warnings, and record why: 'it is a hall'.",
    ),
]


def accepting(reading: Reading, reason: str | None) -> Reading:
    """Return the reading with the user's reason to accept it; ConfigError if it is empty."""
    if reason is None:
        return reading
    words = ' '.join(reason.split())
    if not words:
        raise ConfigError("--accept: expected a reason, e.g. --accept 'it is a hall'")
    return replace(reading, accepted=words)


def verdict_on(
    reading: Reading, tree: FpnetConfig, invocation: Invocation, picture: str = ''
) -> PlanVerdict:
    """Return the verdict on a plan; ``picture`` is the path of the plot of its parse."""
    from fpnet.plan_check.verdict import verdict_of
    from fpnet_core.segmentation import told_scale

    segmentation = reading.segmented(tree.segmentation)
    told = told_scale(reading.grid, segmentation, tree.segmentation)
    return verdict_of(reading, segmentation, invocation, told, picture)


@contextmanager
def refusal_as_json(invocation: Invocation, json_path: Path | None) -> Iterator[None]:
    """Write the verdict on an unreadable drawing as JSON, then re-raise the error."""
    try:
        yield
    except MapFormatError as error:
        from fpnet.plan_check.verdict import unreadable

        common.write_json(json_path, {'verdict': unreadable(error, invocation).as_json()})
        raise
