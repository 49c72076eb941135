# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Doorways closed by their lintels: the paper's prior that doors are lower than ceilings."""

from __future__ import annotations

from dataclasses import dataclass
import math

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.segmentation.openings import Opening, narrowest_line
from fpnet_core.segmentation.scene import Mask

# A doorway is neither narrower nor wider than this [m].
_MIN_WIDTH_M, _MAX_WIDTH_M = 0.5, 3.0
# Share of the opening line under which high returns must have been seen.
_MIN_COVERAGE = 0.35
# High returns this near to the opening line belong to it: half of a thick wall [m].
_LINE_REACH_M = 0.3
# Free space must go on for so far on both sides of a doorway [m].
_PASSAGE_M = 0.5
# How far from the line, in both directions, a room is looked for [m].
_ROOM_REACH_M = 0.8


@dataclass(frozen=True, eq=False)
class LintelDoor:
    """A doorway's closing line ``ends_rc (2, 2)`` in cells of the full raster."""

    ends_rc: NDArray[np.float64]
    cell_m: float

    def between(self, labels: NDArray[np.int32]) -> Opening:
        """Return the opening with the rooms of ``labels (H, W)`` nearest on both sides."""
        along = self.ends_rc[1] - self.ends_rc[0]
        across = np.array([-along[1], along[0]]) / np.hypot(*along)
        rooms = (
            _first_label(labels, self.ends_rc, across * sign, self.cell_m) for sign in (1, -1)
        )
        low, high = sorted(rooms)
        half_m = 0.5 * float(np.hypot(*along)) * self.cell_m
        return Opening((low, high), self.ends_rc, half_m, has_lintel=True)


def _first_label(
    labels: NDArray[np.int32],
    ends: NDArray[np.float64],
    across: NDArray[np.float64],
    cell_m: float,
) -> int:
    """Return the most frequent label on the first line beside ``ends`` that meets a room."""
    shares = np.linspace(0.2, 0.8, 7)[:, None]
    points = ends[0] + shares * (ends[1] - ends[0])
    limits = np.array(labels.shape) - 1
    for offset in np.arange(1.0, _ROOM_REACH_M / cell_m):
        cells = np.clip(np.rint(points + offset * across), 0, limits).astype(np.int64)
        seen = labels[cells[:, 0], cells[:, 1]]
        seen = seen[seen > 0]
        if seen.size:
            return int(np.bincount(seen).argmax())
    return 0


def find_lintels(lintel: Mask, free: Mask, cell_m: float) -> tuple[Mask, list[LintelDoor]]:
    """
    Turn high returns over free space into closed doorways.

    Parameters
    ----------
    lintel : (H, W) bool, free cells below a high return
    free : (H, W) bool
    cell_m : cell edge [true metres]

    Returns
    -------
    closed (H, W) bool : cells of the closing lines, which no region may cross
    doors : one per doorway, largest evidence first; high returns that span no doorway (shelves,
        ducts, beams) close nothing
    """
    closed = np.zeros(lintel.shape, dtype=np.uint8)
    doors: list[LintelDoor] = []
    middles: list[tuple[float, float]] = []
    cells = np.argwhere(lintel).astype(np.float64)
    for centre in _centres(lintel, cell_m):
        if any(_is_beside(door.ends_rc, centre, _LINE_REACH_M / cell_m) for door in doors):
            continue
        ends = narrowest_line(
            free, centre, _MAX_WIDTH_M / cell_m, _LINE_REACH_M / cell_m, _MIN_WIDTH_M / cell_m
        )
        middle = (float(ends[0, 0] + ends[1, 0]) / 2, float(ends[0, 1] + ends[1, 1]) / 2)
        known = any(math.dist(middle, other) * cell_m < _MIN_WIDTH_M for other in middles)
        width_m = math.dist(ends[0], ends[1]) * cell_m
        if (
            known
            or not _MIN_WIDTH_M <= width_m <= _MAX_WIDTH_M
            or _coverage(cells, ends, cell_m) < _MIN_COVERAGE
            or not _is_passage(free, ends, cell_m)
        ):
            continue
        doors.append(LintelDoor(ends, cell_m))
        middles.append(middle)
        start, stop = np.rint(ends[:, ::-1]).astype(int).tolist()
        cv2.line(closed, start, stop, 1, thickness=2)
    return closed.astype(bool) & free, doors


def _is_beside(ends: NDArray[np.float64], place: tuple[float, float], reach: float) -> bool:
    """Tell whether ``place`` lies within ``reach`` cells of the line ``ends``."""
    (r0, c0), (r1, c1) = ends.tolist()
    dr, dc = r1 - r0, c1 - c0
    share = ((place[0] - r0) * dr + (place[1] - c0) * dc) / max(dr * dr + dc * dc, 1e-9)
    share = min(max(share, 0.0), 1.0)
    return math.hypot(place[0] - r0 - share * dr, place[1] - c0 - share * dc) <= reach


def _centres(lintel: Mask, cell_m: float) -> list[tuple[float, float]]:
    """
    Return a cell in the middle of each component of high returns, largest first.

    Components with too few high returns around them to cover even the narrowest doorway are
    left out: most of a long submap's are such specks.
    """
    mask = lintel.astype(np.uint8)
    window = 2 * round(_MIN_WIDTH_M / cell_m) + 1
    around = cv2.boxFilter(mask, cv2.CV_32S, (window, window), normalize=False)
    dense = mask * (around >= _MIN_COVERAGE * _MIN_WIDTH_M / cell_m).astype(np.uint8)
    _, components, stats, centroids = cv2.connectedComponentsWithStats(dense, connectivity=8)
    order = np.argsort(-stats[1:, cv2.CC_STAT_AREA], kind='stable') + 1
    cells = np.argwhere(components > 0)
    owner = components[components > 0]
    middle: list[tuple[float, float]] = []
    for k in order.tolist():
        own = cells[owner == k]
        nearest = own[np.argmin(((own - centroids[k, ::-1]) ** 2).sum(axis=1))]
        middle.append((float(nearest[0]), float(nearest[1])))
    return middle


def _is_passage(free: Mask, ends: NDArray[np.float64], cell_m: float) -> bool:
    """Tell whether ``free (H, W)`` goes on in the middle of a line on both of its sides."""
    along = ends[1] - ends[0]
    across = np.array([-along[1], along[0]]) / np.hypot(*along)
    shares = np.array([0.4, 0.5, 0.6])[:, None]
    middle = ends[0] + shares * along
    limits = np.array(free.shape) - 1
    for offset in np.arange(-_PASSAGE_M, _PASSAGE_M + cell_m, cell_m) / cell_m:
        cells = np.clip(np.rint(middle + offset * across), 0, limits).astype(np.int64)
        if not free[cells[:, 0], cells[:, 1]].any():
            return False
    return True


def _coverage(cells: NDArray[np.float64], ends: NDArray[np.float64], cell_m: float) -> float:
    """Return the share of the line ``ends`` that has a high return beside it."""
    along = ends[1] - ends[0]
    length = float(np.hypot(*along))
    unit = along / length
    offset = cells - ends[0]
    position = offset @ unit
    distance = np.abs(offset @ np.array([-unit[1], unit[0]]))
    near = (distance * cell_m < _LINE_REACH_M) & (position >= 0.0) & (position <= length)
    return float(np.unique(np.rint(position[near])).size / (np.floor(length) + 1.0))
