# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Differences as values: pieces of a drawing with a kind and a confidence."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import freeze_field
from fpnet_core.types import GridMap

LIKELY = 0.5
"""Given: confidence from which a difference is more probable than none."""


class DifferenceKind(StrEnum):
    """In what a place of the drawing is not as it was seen."""

    WALL = 'wall not drawn'
    MISSING = 'drawn wall not there'
    SHUT = 'door shut'
    FURNITURE = 'furniture'


@dataclass(frozen=True, eq=False)
class Difference:
    """
    One piece that differs.

    ``ends (2, 2)`` are those of its longer axis in the drawing's frame [m], ``length_m`` its
    length in the drawing's metres, ``confidence`` the probability that it is what ``kind`` says.
    ``figures`` are what that rests on, in the order of the kind's weights.
    """

    kind: DifferenceKind
    ends: NDArray[np.float64]
    length_m: float
    confidence: float
    figures: NDArray[np.float64]

    def __post_init__(self) -> None:
        """Check shapes."""
        freeze_field(self, 'ends', np.float64, (2, 2))
        freeze_field(self, 'figures', np.float64, (None,))

    @property
    def is_likely(self) -> bool:
        """Tell whether it is more probable than not."""
        return self.confidence >= LIKELY

    @property
    def is_of_drawing(self) -> bool:
        """Tell whether it is the drawing that is out of date: doors open, furniture moves."""
        return self.kind in (DifferenceKind.WALL, DifferenceKind.MISSING)


@dataclass(frozen=True, eq=False)
class Differences:
    """
    All that differs between a drawing and what was seen of the building.

    Parameters
    ----------
    grid : the drawing
    pieces : what differs: doors, what is not drawn (furniture among it), what is not there
    piece_of (H, W) int32
        Number of the piece of each cell of the drawing, from 1; 0 where nothing differs.
    is_seen (H, W) bool
        Cells of which something was seen.
    """

    grid: GridMap
    pieces: tuple[Difference, ...]
    piece_of: NDArray[np.int32]
    is_seen: NDArray[np.bool_]

    def __post_init__(self) -> None:
        """Check that the rasters agree."""
        freeze_field(self, 'piece_of', np.int32, self.grid.shape)
        freeze_field(self, 'is_seen', np.bool_, self.grid.shape)

    @property
    def likely(self) -> tuple[Difference, ...]:
        """Return the pieces that are more probable than not, without furniture."""
        return tuple(
            each
            for each in self.pieces
            if each.is_likely and each.kind is not DifferenceKind.FURNITURE
        )

    @property
    def confidence(self) -> NDArray[np.float32]:
        """Probability ``(H, W)`` that the drawing is wrong at a cell; 0 where nothing was seen."""
        of_piece = [0.0, *(each.confidence * each.is_of_drawing for each in self.pieces)]
        return np.array(of_piece, dtype=np.float32)[self.piece_of]
