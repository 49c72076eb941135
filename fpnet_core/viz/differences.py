# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A drawing with all that differs from it marked, in metres of its frame."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fpnet_core.differences import DifferenceKind, Differences
from fpnet_core.viz.segmentation import Colour, draw_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Chosen, not measured:
_COLOURS: dict[DifferenceKind, Colour] = {
    DifferenceKind.WALL: (0.85, 0.1, 0.1),
    DifferenceKind.MISSING: (0.1, 0.3, 0.9),
    DifferenceKind.SHUT: (0.1, 0.6, 0.2),
    DifferenceKind.FURNITURE: (0.75, 0.6, 0.2),
}
_MARK = 5.0  # marker size of a cell


def draw_differences(ax: Axes, found: Differences) -> None:
    """Draw a drawing and what differs; the surer, the more opaque."""
    draw_grid(ax, found.grid)
    told: set[DifferenceKind] = set()
    for number, piece in enumerate(found.pieces, start=1):
        x, y = found.grid.rc_to_xy(np.argwhere(found.piece_of == number)).T
        label = '_' if piece.kind in told else piece.kind.value
        alpha = max(piece.confidence, 0.2) if piece.is_likely else 0.15
        ax.plot(
            x, y, 's', color=_COLOURS[piece.kind], markersize=_MARK / 2, alpha=alpha,
            markeredgewidth=0.0, label=label,
        )  # fmt: skip
        told.add(piece.kind)
    if told:
        ax.legend(loc='upper right')


def save_differences(found: Differences, path: Path) -> None:
    """Write the picture."""
    from matplotlib.figure import Figure

    height, width = found.grid.shape
    figure = Figure(figsize=(14.0, max(4.0, 14.0 * height / width)), layout='constrained')
    draw_differences(figure.add_subplot(), found)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
