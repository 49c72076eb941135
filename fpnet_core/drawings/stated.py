# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scale of a drawing as stated by its user or by the drawing itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fpnet_core.drawings.annotations import annotated_scale, label_votes
from fpnet_core.drawings.types import (
    Array,
    Drawing,
    DrawingScale,
    Label,
    Length,
    ReadOptions,
    ScaleSource,
)
from fpnet_core.drawings.votes import Vote
from fpnet_core.raster.pixels import growth_at, map_points


@dataclass(frozen=True)
class SaidScale:
    """
    Stated scale of a drawing; not stated if ``pixel`` and ``length`` are None.

    Parameters
    ----------
    pixel : scale of its pixels
    length : (x1, y1, x2, y2, metres), coordinates in pixels
    labels : texts, if they may refine the scale once rooms are known
    votes : their votes for metres per pixel that need no rooms
    """

    pixel: DrawingScale | None = None
    length: Length | None = None
    labels: tuple[Label, ...] = ()
    votes: tuple[Vote, ...] = ()

    @classmethod
    def of(cls, drawing: Drawing, options: ReadOptions) -> SaidScale:
        """Return the scale stated by the user, else by the drawing."""
        if options.resolution_m is not None:
            return cls(exact(options.resolution_m, ScaleSource.STATED, 'stated'))
        if options.length is not None:
            return cls(length=options.length)
        if drawing.scale is not None:
            return cls(drawing.scale)
        votes = label_votes(drawing)
        return cls(annotated_scale(drawing, votes), None, drawing.labels, tuple(votes))

    def at(self, H_cell_pixel: Array, shape: tuple[int, ...]) -> tuple[DrawingScale, float] | None:
        """
        Return the scale of the drawing's pixels and the edge of a cell [m]; None if not stated.

        ``H_cell_pixel (3, 3)`` maps the pixels to cells of ``shape``. If perspective was removed,
        the scale is that of a pixel at the centre of the building.
        """
        per_pixel = cells_per_pixel(H_cell_pixel, shape)
        if self.length is not None:
            x1, y1, x2, y2, metres = self.length
            ends = map_points(H_cell_pixel, np.array([[x1, y1], [x2, y2]]))
            cell_m = metres / float(np.hypot(*(ends[1] - ends[0])))
            why = f'from a length of {metres:g} m'
            return exact(cell_m * per_pixel, ScaleSource.LENGTH, why), cell_m
        if self.pixel is None:
            return None
        return self.pixel, self.pixel.resolution_m / per_pixel

    def cell_m(self, H_cell_pixel: Array, shape: tuple[int, ...]) -> float | None:
        """Return the edge of a cell [m]; None if not stated."""
        said = self.at(H_cell_pixel, shape)
        return None if said is None else said[1]


def cells_per_pixel(H_cell_pixel: Array, shape: tuple[int, ...]) -> float:
    """Return the length of a pixel in cells, at the centre of a map of ``shape``."""
    middle = np.array(shape[::-1]) / 2.0
    back = np.asarray(np.linalg.inv(H_cell_pixel), dtype=np.float64)
    return 1.0 / growth_at(back, middle)


def exact(metres: float, source: ScaleSource, why: str) -> DrawingScale:
    """Return a scale of ``metres`` per pixel without uncertainty."""
    return DrawingScale(metres, metres, metres, source, why)
