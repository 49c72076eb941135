# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plot of a drawing with its differences marked, in metres of its frame."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fpnet.viz.pictures import saved_figure
from fpnet.viz.segmentation import PALE, Colour, draw_grid, show_raster
from fpnet_core.differences import DifferenceKind, Differences
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.pixels import corners_xy

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Chosen, not measured:
DIFFERENCE_COLOURS: dict[DifferenceKind, Colour] = {
    DifferenceKind.WALL: (0.85, 0.1, 0.1),
    DifferenceKind.MISSING: (0.1, 0.3, 0.9),
    DifferenceKind.SHUT: (0.1, 0.6, 0.2),
    DifferenceKind.FURNITURE: (0.75, 0.6, 0.2),
}
_FAINTEST = 0.25  # opacity of improbable differences
_SHOWN_M = 0.15  # differences are thickened by this, as one cell is too thin to see
_WIDTH_IN = 11.0
_TALLEST = 2.5  # height of the picture over its width, at most


def draw_differences(ax: Axes, found: Differences) -> None:
    """Draw a drawing and its differences, with their confidence as opacity."""
    draw_grid(ax, found.grid, PALE)
    tint = np.zeros((*found.grid.shape, 4))
    reach = max(1, round(_SHOWN_M / found.grid.resolution))
    for number, piece in enumerate(found.pieces, start=1):
        alpha = max(piece.confidence, _FAINTEST) if piece.is_likely else _FAINTEST
        tint[grown(found.piece_of == number, reach)] = (*DIFFERENCE_COLOURS[piece.kind], alpha)
    show_raster(ax, found.grid, tint)
    present = {piece.kind for piece in found.pieces}
    for kind, colour in DIFFERENCE_COLOURS.items():
        if kind in present:
            ax.plot([], [], 's', color=colour, label=kind.value)
    if present:
        ax.legend(loc='upper center', bbox_to_anchor=(0.5, -0.08), ncols=len(present))


def save_differences(found: Differences, path: Path) -> None:
    """Write the plot of :func:`draw_differences`."""
    width, height = np.ptp(corners_xy(found.grid), axis=0)
    tall = min(float(height / width), _TALLEST)
    with saved_figure(path, (_WIDTH_IN, _WIDTH_IN * tall + 1.0), 110) as figure:
        draw_differences(figure.add_subplot(), found)
