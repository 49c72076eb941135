# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Geometric features of a line that may divide two rooms, however it was found.

They measure the space behind and beside the line, the walls at its ends, and seen and unseen
cells. Both sides and both ends are sorted by size, so their order does not matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.rays import marked, run_lengths

Array = NDArray[np.float64]

# Numerical: depths beside the line at which the width of the space is measured [m].
_DEPTHS_M = (0.2, 0.4, 0.7, 1.0, 1.5, 2.2, 3.0)
_NARROW = 4  # numerical: the first this many depths decide which side is narrower
_BESIDE_M = 1.5  # numerical: the space is measured up to this far beyond the line's ends
_AHEAD_M = 8.0  # numerical: range of the distance perpendicular to the line
_WALL_M = 1.2  # numerical: range in which the wall continues from the line's ends
_THICK_M = 1.0  # numerical: largest measured wall thickness
_NEAR_M = 0.15  # numerical: an end meets a wall within this distance
_BAND_M = 0.4  # numerical: furniture and lintels count this near to the line
_DISC_M = 1.2  # numerical: radius around the middle in which unseen cells are counted
_DISC_STEPS = 8.0  # numerical: samples per radius
_BLOCKED_M = -0.5  # numerical: value for the space beside a place that is not free
_BLUR_CELLS = 5  # numerical: window over which a wall face's direction is measured
_LEAST_CELLS = 1e-6  # numerical: smallest length, so that every line has a direction

_BESIDE = tuple(
    f'{end}_{side}_{depth}'
    for depth in range(len(_DEPTHS_M))
    for side in ('narrow', 'wide')
    for end in ('least', 'most')
)
LINE_FIGURES = (
    *_BESIDE,
    'ahead_least', 'ahead_most',
    'wall_least', 'wall_most',
    'thick_least', 'thick_most',
    'met_least', 'met_most',
    'unseen_least', 'unseen_most',
    'furniture', 'lintel', 'width', 'off_walls',
)  # fmt: skip
"""Features of a line; lengths in metres, the rest in [0, 1]."""


@dataclass(frozen=True, eq=False)
class LineMasks:
    """
    Masks (H, W) from which line features are measured.
    ``furniture`` was removed from the map; ``lintel`` marks cells below a lintel.
    """

    passable: Mask
    unseen: Mask
    furniture: Mask
    lintel: Mask
    cell_m: float


def line_figures(ends: Array, around: LineMasks) -> Array:
    """
    Return the :data:`LINE_FIGURES` (L, D) of lines.

    Parameters
    ----------
    ends : (L, 2, 2) row and column of their ends, fractional
    around : masks of the surrounding cells
    """
    if not len(ends):
        return np.zeros((0, len(LINE_FIGURES)))
    direction = wall_direction(around.passable)
    along = ends[:, 1] - ends[:, 0]
    lengths = np.maximum(np.hypot(*along.T), _LEAST_CELLS)
    lines = _Lines(ends.astype(np.float64), along / lengths[:, None], lengths)
    off = np.abs(np.sin(2.0 * (np.arctan2(along[:, 0], along[:, 1]) - direction)))
    beside, ahead, hidden = _side_features(lines, around)
    band = _BAND_M / around.cell_m
    return np.column_stack(
        [
            beside,
            ahead,
            _end_features(lines, around),
            hidden,
            _band_share(around.furniture, lines, band, is_across=False),
            _band_share(around.lintel, lines, band, is_across=True),
            lengths * around.cell_m,
            off,
        ]
    )


@dataclass(frozen=True, eq=False)
class _Lines:
    """Lines with ``ends (L, 2, 2)``, the directions ``along (L, 2)`` and ``lengths (L,)``."""

    ends: Array
    along: Array
    lengths: Array

    @property
    def across(self) -> Array:
        """Return the normals (L, 2), unit vectors."""
        return np.stack([-self.along[:, 1], self.along[:, 0]], axis=1)

    @property
    def middles(self) -> Array:
        """Return the middles (L, 2)."""
        return np.asarray(self.ends.mean(axis=1))


def wall_direction(passable: Mask) -> float:
    """Return the main direction of wall faces [rad], modulo a quarter turn."""
    # Differences over several cells resolve angles that differences of neighbours do not.
    size = (_BLUR_CELLS, _BLUR_CELLS)
    blurred = np.asarray(
        cv2.boxFilter(passable.view(np.uint8), cv2.CV_16S, size, normalize=False), np.int16
    )
    steepest = _BLUR_CELLS**2
    d_row = blurred[2:, 1:-1] - blurred[:-2, 1:-1]
    d_col = blurred[1:-1, 2:] - blurred[1:-1, :-2]
    side = 2 * steepest + 1
    slopes = (side * d_row + d_col).ravel()
    slopes = slopes[slopes != 0].astype(np.int64) + side * side // 2
    counts = np.bincount(slopes, minlength=side * side)
    # The fourth power maps quarter turns to one angle; dividing by |slope|^3 weights by length.
    row, col = np.divmod(np.arange(side * side), side)
    slope = (col - steepest) + 1j * (row - steepest)
    turned = counts * slope**4 / np.maximum(np.abs(slope), 1.0) ** 3
    return float(np.angle(turned.sum()) / 4.0)


def _by_size(values: Array) -> Array:
    """Return each pair of values (L, 2) sorted, smaller first."""
    return np.sort(values, axis=1)


def _side_features(lines: _Lines, around: LineMasks) -> tuple[Array, Array, Array]:
    """
    Return features of the space on both sides of lines.

    These are the free extent beside them (L, 28), the free distance perpendicular to them (L, 2),
    and the unseen share (L, 2).
    """
    free, cell_m, middles = around.passable, around.cell_m, lines.middles[:, None]
    normals = lines.across[:, None] * np.array([[1.0], [-1.0]])  # line, side
    # Start one cell off: the line's own cells may be closed.
    ahead = run_lengths(free, False, middles + normals, normals, _AHEAD_M / cell_m)
    depths = np.array(_DEPTHS_M) / cell_m
    places = middles[:, :, None] + depths[:, None] * normals[:, :, None]  # line, side, depth
    is_free = marked(free, places, False) & (ahead[..., None] >= depths - 2.0)
    half = 0.5 * lines.lengths[:, None, None, None]
    limits = np.where(is_free[..., None], half + _BESIDE_M / cell_m, 0.0)
    directions = lines.along[:, None, None, None] * np.array([[1.0], [-1.0]])
    wide = run_lengths(free, False, places[:, :, :, None], directions, limits) - half
    extents = np.maximum(np.sort(wide, axis=3) * cell_m, _BLOCKED_M)
    extents[~is_free] = _BLOCKED_M
    first, second = extents[:, :, :_NARROW].sum(axis=(2, 3)).T
    order = np.where((first > second)[:, None], [1, 0], [0, 1])
    extents = np.take_along_axis(extents, order[:, :, None, None], axis=1)
    beside = extents.swapaxes(1, 2).reshape(len(extents), -1)
    return beside, _by_size(ahead) * cell_m, _by_size(_unseen_beside(lines, around))


def _unseen_beside(lines: _Lines, around: LineMasks) -> Array:
    """Return the share of unseen cells in the half discs on both sides of lines (L, 2)."""
    reach = _DISC_M / around.cell_m
    places = np.arange(-int(reach), int(reach) + 1, max(1, int(reach / _DISC_STEPS)))
    offsets = np.stack(np.meshgrid(places, places), axis=-1).reshape(-1, 2).astype(np.float64)
    offsets = offsets[(offsets * offsets).sum(axis=1) <= reach * reach]
    is_unseen = marked(around.unseen, lines.middles[:, None] + offsets, True)
    side = offsets[:, 0] * lines.across[:, :1] + offsets[:, 1] * lines.across[:, 1:]
    is_on = np.stack([side > 0.0, side < 0.0], axis=1)  # line, side, place
    return np.asarray((is_unseen[:, None] & is_on).sum(axis=2) / np.maximum(is_on.sum(axis=2), 1))


def _end_features(lines: _Lines, around: LineMasks) -> Array:
    """Return features of the ends (L, 6): continuing wall, wall thickness, wall contact."""
    cell_m, outwards = around.cell_m, lines.along[:, None] * np.array([[-1.0], [1.0]])
    solid = ~(around.passable | around.unseen)
    near = _NEAR_M / cell_m
    wall, met = (
        _solid_share(solid, lines.ends, outwards, reach) for reach in (_WALL_M / cell_m, near)
    )
    across = lines.across[:, None, None] * np.array([[-1.0], [1.0]])
    starts = (lines.ends + near * outwards)[:, :, None]
    closed = ~around.passable
    thick = run_lengths(closed, True, starts, across, _THICK_M / cell_m).sum(axis=2) * cell_m
    return np.concatenate([_by_size(wall), _by_size(thick), _by_size(met)], axis=1)


def _solid_share(solid: Mask, places: Array, directions: Array, reach: float) -> Array:
    """Return the share (L, 2) of solid cells on rays from places; a solid cell beside counts."""
    steps = np.arange(1, max(2, int(reach)) + 1)
    across = np.stack([-directions[..., 1], directions[..., 0]], axis=-1)
    on = places[..., None, :] + steps[:, None] * directions[..., None, :]
    beside = np.array([0.0, -1.0, 1.0])[:, None, None]
    found = marked(solid, on[..., None, :, :] + beside * across[..., None, None, :], False)
    return np.asarray(found.any(axis=-2).mean(axis=-1))


def _band_share(mask: Mask, lines: _Lines, band: float, is_across: bool) -> Array:
    """
    Return the share (L,) of the cells of bands around lines that lie in ``mask``.

    With ``is_across``, the share of places along each line that have any mask cell across it.
    """
    if not mask.any():
        return np.zeros(len(lines.ends))
    half = 0.5 * lines.lengths + (0.0 if is_across else band)
    reach, wide = np.maximum(half.astype(np.int64), 1), max(1, int(band))
    count = 2 * reach + 1
    line = np.repeat(np.arange(len(count)), count)
    begin = np.cumsum(count) - count
    along = (np.arange(len(line)) - begin[line] - reach[line])[:, None]
    places = (lines.middles[line] + along * lines.along[line])[:, None]
    offsets = np.arange(-wide, wide + 1)[:, None]
    found = marked(mask, places + offsets * lines.across[line][:, None], False)
    share = found.any(axis=1) if is_across else found.mean(axis=1)
    return np.asarray(np.add.reduceat(share, begin, dtype=np.float64) / count)
