# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The exact Euclidean distance transform, to the last digit the same wherever arrays lie."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.blocks import block_middles


def cells_to_nearest(mask: NDArray[np.bool_], step: int = 1) -> NDArray[np.float32]:
    """
    Return the distance (H, W) float32 from each cell to the nearest True cell, in cells.

    With a ``step`` only of the cells in the middle of blocks of that side, as
    :func:`~fpnet_core.raster.blocks.block_middles` chooses them.

    OpenCV's last digit depends on where its arrays lie in memory, so that equal maps would be
    cut differently once in a while. Squared distances are whole numbers, which settles them.
    """
    cells = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    distance = block_middles(np.asarray(cells, dtype=np.float32), step)
    for settle in (np.square, np.rint, np.sqrt):
        settle(distance, out=distance)
    return distance


def clearance_of(free: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return the distance (H, W) from each cell to what is not free, beyond the edge too."""
    return cells_to_nearest(np.pad(~free, 1, constant_values=True))[1:-1, 1:-1]


def nearest_labels(
    labels: NDArray[np.int32],
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return about how many cells (H, W) it is to the nearest label above 0, and that label."""
    is_labelled = labels > 0
    cells, source = cv2.distanceTransformWithLabels(
        (~is_labelled).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    label_of = np.zeros(int(source.max()) + 1, np.int32)
    label_of[source[is_labelled]] = labels[is_labelled]
    return np.asarray(cells, np.float32), label_of[source]


def near_code(mask: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """
    Return squared distances (H, W) to the nearest True cell, 3 for everything beyond 2.

    Within a cell and its neighbours these are 0, 1 and 2; far cheaper than all distances.
    """
    cells = mask.astype(np.uint8)
    beside = cv2.dilate(cells, cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)))
    around = cv2.dilate(cells, np.ones((3, 3), np.uint8))
    return np.asarray(3 - cells - beside - around, dtype=np.uint8)
