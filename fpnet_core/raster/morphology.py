# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Morphology of masks: dilation, erosion, opening, closing and label spreading."""

from __future__ import annotations

from typing import Any, TypeVar

import cv2
from numba import njit
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.windows import framed

Mask = NDArray[np.bool_]
Kernel = NDArray[np.uint8]
Label = TypeVar('Label', np.int32, np.uint8)


def square(side: int) -> Kernel:
    """Return the kernel (side, side) of a square."""
    return np.ones((side, side), np.uint8)


def disc(diameter: int) -> Kernel:
    """Return the kernel (diameter, diameter) of a disc; it has a central cell if that is odd."""
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter,) * 2), np.uint8)


def cross() -> Kernel:
    """Return the kernel (3, 3) of a cell and its four neighbours."""
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)), np.uint8)


def grown(mask: Mask, reach: int) -> Mask:
    """Return the cells (H, W) within ``reach`` of ``mask (H, W)``, in the maximum norm."""
    return grown_by(mask, square(2 * reach + 1))


def grown_by(mask: Mask, kernel: Kernel) -> Mask:
    """Return the mask (H, W) dilated by ``kernel (K, K)``, K odd."""
    return np.asarray(cv2.dilate(mask.view(np.uint8), kernel)).view(np.bool_)


def shrunk(mask: Mask, reach: int) -> Mask:
    """Return ``mask (H, W)`` without the cells within ``reach`` of a cell outside it."""
    return shrunk_by(mask, square(2 * reach + 1))


def shrunk_by(mask: Mask, kernel: Kernel) -> Mask:
    """Return the mask (H, W) eroded by ``kernel (K, K)``; cells off the raster count as True."""
    return np.asarray(cv2.erode(mask.view(np.uint8), kernel)).view(np.bool_)


def opened(mask: Mask, diameter: int) -> Mask:
    """Return ``mask (H, W)`` opened by a disc of ``diameter`` cells."""
    return opened_by(mask, disc(diameter))


def opened_by(mask: Mask, kernel: Kernel, is_beyond: bool = False) -> Mask:
    """
    Return ``mask (H, W)`` opened by ``kernel (K, K)``.

    ``is_beyond`` is the mask's value beyond the edge.
    """
    side, anchor = len(kernel), (len(kernel) - 1) // 2
    padded = framed(mask, (side, side), (side, side), is_beyond)
    # With even kernels, only a mirrored kernel in the dilation avoids a shift by one cell.
    eroded = cv2.erode(padded.view(np.uint8), kernel)
    found = cv2.dilate(eroded, kernel[::-1, ::-1], anchor=(anchor, anchor))
    return np.ascontiguousarray(found[side:-side, side:-side]).view(np.bool_)


def closed(mask: Mask, side: int) -> Mask:
    """Return ``mask (H, W)`` closed by a square of ``side`` cells."""
    return ~opened_by(~mask, square(side), is_beyond=True)


def is_peak(values: NDArray[Any], side: int) -> Mask:
    """Return which of ``values (H, W)`` are the maximum of their square of ``side`` cells."""
    return np.asarray(values >= cv2.dilate(values, square(side)))


def spread(labels: NDArray[Label], into: Mask, kernel: Kernel, steps: int) -> NDArray[Label]:
    """
    Spread ``labels (H, W)`` by ``steps`` into unlabelled cells of a mask, in place; return them.

    ``into (H, W)`` is the mask. A step reaches as far as ``kernel (3, 3)``, which is symmetric. A
    cell that several labels reach in the same step takes the largest.
    """
    framing = framed(labels.astype(np.int32), (1, 1), (1, 1))
    left = np.flatnonzero(framed(into & (labels == 0), (1, 1), (1, 1)))
    covered = np.flatnonzero(kernel)
    beside = (covered // 3 - 1) * framing.shape[1] + covered % 3 - 1
    _spread(framing.reshape(-1), left, beside, steps)
    labels[:] = framing[1:-1, 1:-1]
    return labels


@njit(cache=True, nogil=True)
def _spread(found, left, beside, steps):  # type: ignore[no-untyped-def]
    """Carry out :func:`spread` in place; ``left (K,)`` are the flat indices of cells to label."""
    values, count = np.empty(len(left), np.int32), len(left)
    for _ in range(steps):
        for k in range(count):
            values[k] = 0
            for offset in beside:
                values[k] = max(values[k], found[left[k] + offset])
        before, count = count, 0
        for k in range(before):
            found[left[k]] = values[k]
            left[count] = left[k]
            count += values[k] == 0
        if count == before:
            break
