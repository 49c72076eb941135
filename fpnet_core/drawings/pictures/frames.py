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
# What no outer wall is, with its windows, doors and partitions:
_RULED_SIDE, _RULED_SIDES = 0.9, 3  # of so many sides is one line
_LINE_SHARE, _LINE_PX = 0.0075, 3.0  # of the longer side, or pixels: a line is no thicker
_FREE_SIDE, _FREEST_SIDE = 0.7, 0.98  # of three sides and of one in one piece is free of all else


def without_frames(ink: Mask, is_sure: bool = False) -> tuple[list[Box], Mask]:
    """
    Return the boxes of frames around everything, outermost first, and the ink without.

    ``is_sure`` leaves what may be the outer wall of a hall.
    """
    frames: list[Box] = []
    for _ in range(_MAX_FRAMES):
        labels, stats = pieces_of(ink)
        found = _outermost_frame(ink, labels, stats, is_sure)
        if found is None:
            break
        left, top, width, height, _ = stats[found].tolist()
        frames.append((left, top, left + width, top + height))
        ink = ink & (labels != found)
    return frames, ink


def _outermost_frame(
    ink: Mask, labels: NDArray[np.int32], stats: NDArray[np.int32], is_sure: bool
) -> int | None:
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
        is_frame = is_around and _is_bare(own, inset) and (not is_sure or _is_ruled(own, inset))
        if is_frame and _stands_apart(others, is_sure):
            return int(label)
    return None


def _stands_apart(others: Mask, is_sure: bool) -> bool:
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
    return _outermost_frame(others, *pieces_of(others), is_sure) is not None


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
    blank = _blanks(own, inset)
    return blank[0] > _BLANK_WORST and blank[1] > _BLANK_SIDE


def _is_ruled(own: Mask, inset: int) -> bool:
    """
    Tell whether a rectangle is ruled in single lines that have little attached to them.

    A title block lies in a corner or along one side; walls are thick or two lines, have windows
    and doors, and partitions on all sides.
    """
    thickest = max(_LINE_PX, _LINE_SHARE * max(own.shape))
    strips = (own[:inset], own[-inset:], own[:, :inset].T, own[:, -inset:].T)
    ruled = sorted(_ruled_share(strip, thickest) for strip in strips)
    _, *free = _blanks(own, inset)
    is_free = free[0] > _FREE_SIDE and free[-1] > _FREEST_SIDE
    return ruled[-_RULED_SIDES] > _RULED_SIDE and is_free


def _ruled_share(strip: Mask, thickest: float) -> float:
    """Return the share of a strip's columns (D, L) that a single thin line crosses."""
    starts = strip[0].astype(np.int64) + (strip[1:] & ~strip[:-1]).sum(axis=0)
    return float(((starts == 1) & (strip.sum(axis=0) <= thickest)).mean())


def _blanks(own: Mask, inset: int) -> list[float]:
    """Return the longest run without ink beside each of four sides, as its share, least first."""
    sides = (own[inset], own[-1 - inset], own[:, inset], own[:, -1 - inset])
    return sorted(_longest_blank(side[inset:-inset]) for side in sides)


def _longest_blank(side: Mask) -> float:
    """Return the share of the longest run without ink."""
    marks = np.concatenate([[-1], np.flatnonzero(side), [side.size]])
    return float((np.diff(marks) - 1).max() / max(side.size, 1))
