# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet train``: registers the training commands, one module ``train_<name>.py`` each."""

from __future__ import annotations

import typer

from fpnet_lab.cli import (
    train_covariance,
    train_doors,
    train_doubts,
    train_evidence,
    train_finetune,
    train_matcher,
    train_parser,
    train_scale,
    train_scorer,
)

app = typer.Typer(help='Train the networks and fit the models.', no_args_is_help=True)
app.command('matcher')(train_matcher.command)
app.command('finetune')(train_finetune.command)
app.command('parser')(train_parser.command)
app.command('doors')(train_doors.command)
app.command('scale')(train_scale.command)
app.command('doubts')(train_doubts.command)
app.command('evidence')(train_evidence.command)
app.command('scorer')(train_scorer.command)
app.command('covariance')(train_covariance.command)


@app.callback()
def _group() -> None:
    """
    Train the networks and fit the models.

    Example: fpnet train matcher --data runs/pairs --out runs/train
    """
