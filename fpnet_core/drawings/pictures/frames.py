# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Frames of a sheet: rectangles around everything, with nothing attached to them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.types import Box
from fpnet_core.raster.morphology import Mask
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.raster.windows import window_of

# Chosen, not measured:
_MAX_FRAMES = 4
_FRAME_SPAN = 0.55  # of the drawn extent in both directions: smaller rectangles are no frames
_FRAME_INSET = 0.02  # of a frame's sides: where lines would cross that are attached to it
_DRAWN_SIDE = 0.75  # of each side of a frame is drawn
_BLANK_SIDE = 0.35  # of three sides of a frame in one piece has nothing attached
_BLANK_WORST = 0.25  # of its fourth side
_FACE_DEPTH, _FOLLOWED_SIDES = 0.04, 3  # how near to how many sides a wall's other face is
_FRAMED_INK = 0.2  # of all ink lies inside a frame and is not the frame


def without_frames(ink: Mask) -> tuple[list[Box], Mask]:
    """Return the boxes of frames around everything, outermost first, and the ink without."""
    frames: list[Box] = []
    for _ in range(_MAX_FRAMES):
        labels, stats = pieces_of(ink)
        found = _outermost_frame(ink, labels, stats)
        if found is None:
            break
        left, top, width, height, _ = stats[found].tolist()
        frames.append((left, top, left + width, top + height))
        ink = ink & (labels != found)
    return frames, ink


def _outermost_frame(ink: Mask, labels: NDArray[np.int32], stats: NDArray[np.int32]) -> int | None:
    """Return the label of the largest piece that is a frame."""
    drawn = window_of(ink)
    if drawn is None:
        return None
    extent = np.array([part.stop - part.start for part in drawn[::-1]])
    wide = np.flatnonzero((stats[1:, 2:4] > _FRAME_SPAN * extent).all(axis=1)) + 1
    for label in wide[np.argsort(-stats[wide, 2] * stats[wide, 3].astype(np.int64))]:
        left, top, width, height, _ = stats[label].tolist()
        window = np.s_[top : top + height, left : left + width]
        own = labels[window] == label
        inset = max(3, round(_FRAME_INSET * max(width, height)))
        others = ink[window] & ~own
        is_around = others[inset:-inset, inset:-inset].sum() > _FRAMED_INK * ink.sum()
        if is_around and _is_bare(own, inset) and _stands_apart(others):
            return int(label)
    return None


def _stands_apart(others: Mask) -> bool:
    """
    Tell whether ``others``, what a rectangle goes around, does not follow it closely.

    The outer face of a wall of two lines is a rectangle, too. A frame of two lines follows a
    frame.
    """
    depth = max(3, round(_FACE_DEPTH * max(others.shape)))
    strips = [others[:depth].any(0), others[-depth:].any(0)]
    strips += [others[:, :depth].any(1), others[:, -depth:].any(1)]
    if sum(strip.mean() > _DRAWN_SIDE for strip in strips) < _FOLLOWED_SIDES:
        return True
    return _outermost_frame(others, *pieces_of(others)) is not None


def _is_bare(own: Mask, inset: int) -> bool:
    """Tell whether a piece is a rectangle with hardly anything attached to its inner side."""
    edges = (
        own[:inset].any(0),
        own[-inset:].any(0),
        own[:, :inset].any(1),
        own[:, -inset:].any(1),
    )
    if min(edge.mean() for edge in edges) < _DRAWN_SIDE:
        return False
    sides = (own[inset], own[-1 - inset], own[:, inset], own[:, -1 - inset])
    blank = sorted(_longest_blank(side[inset:-inset]) for side in sides)
    return blank[0] > _BLANK_WORST and blank[1] > _BLANK_SIDE


def _longest_blank(side: Mask) -> float:
    """Return the share of the longest run without ink."""
    marks = np.concatenate([[-1], np.flatnonzero(side), [side.size]])
    return float((np.diff(marks) - 1).max() / max(side.size, 1))
