# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Value types of differences: pieces of a drawing with a kind and a confidence."""

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
    """Type of a difference between drawing and building."""

    WALL = 'wall not drawn'
    MISSING = 'drawn wall not there'
    SHUT = 'door shut'
    FURNITURE = 'furniture'


@dataclass(frozen=True, eq=False)
class Difference:
    """
    One piece that differs.

    ``ends (2, 2)`` are the ends of its longer axis in the drawing's frame [m], ``length_m`` its
    length in the drawing's metres, ``confidence`` the probability that ``kind`` is correct.
    ``figures`` are the features behind it, in the order of the kind's weights.
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
        """Whether the difference is more probable than not."""
        return self.confidence >= LIKELY

    @property
    def is_of_drawing(self) -> bool:
        """Whether the drawing is out of date here; false for doors and furniture, which move."""
        return self.kind in (DifferenceKind.WALL, DifferenceKind.MISSING)


@dataclass(frozen=True, eq=False)
class Differences:
    """
    All differences between a drawing and the observed building.

    Parameters
    ----------
    grid : the drawing
    pieces : closed doors, observed pieces that are not drawn, and missing walls
    piece_of (H, W) int32
        Number of the piece of each cell of the drawing, from 1; 0 without a difference.
    is_seen (H, W) bool
        Observed cells.
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
        """Pieces that are more probable than not, without furniture."""
        return tuple(
            each
            for each in self.pieces
            if each.is_likely and each.kind is not DifferenceKind.FURNITURE
        )

    @property
    def confidence(self) -> NDArray[np.float32]:
        """Probability ``(H, W)`` that the drawing is wrong at a cell; 0 where not observed."""
        of_piece = [0.0, *(each.confidence * each.is_of_drawing for each in self.pieces)]
        return np.array(of_piece, dtype=np.float32)[self.piece_of]
