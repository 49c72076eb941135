# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The exact Euclidean distance transform, to the last digit the same wherever arrays lie."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def cells_to_nearest(mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    """
    Return the distance (H, W) float32 from each cell to the nearest True cell, in cells.

    OpenCV's last digit depends on where its arrays lie in memory, so that equal maps would be
    cut differently once in a while. Squared distances are whole numbers, which settles them.
    """
    cells = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(np.sqrt(np.rint(np.square(cells))), dtype=np.float32)


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
