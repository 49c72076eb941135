# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Openings and closings of masks that stay in place whatever the size of their kernel."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]


def opened(mask: Mask, size: int) -> Mask:
    """Return ``mask (H, W)`` without what a disc of ``size`` cells does not fit into."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    return _opened(np.pad(mask, size), np.asarray(disc, np.uint8))


def closed(mask: Mask, size: int) -> Mask:
    """Return ``mask (H, W)`` with gaps filled that a square of ``size`` cells is too big for."""
    return ~_opened(np.pad(~mask, size, constant_values=True), np.ones((size, size), np.uint8))


def _opened(padded: Mask, kernel: NDArray[np.uint8]) -> Mask:
    """Return a mask opened by ``kernel (K, K)``, without its margin of K cells."""
    size, anchor = len(kernel), (len(kernel) - 1) // 2
    eroded = cv2.erode(padded.astype(np.uint8), kernel)
    # Kernels of even size move a mask by a cell unless the second one is the first one mirrored.
    grown = cv2.dilate(eroded, kernel[::-1, ::-1], anchor=(anchor, anchor))
    return np.asarray(grown[size:-size, size:-size] > 0)
