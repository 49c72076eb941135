# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Doors of a segmentation against those of hand-labelled rooms."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist
from skimage.segmentation import expand_labels

from fpnet_core.raster.morphology import Mask, grown
from fpnet_core.segmentation.agreement import Agreement

# Chosen, not measured:
# Hand-drawn rooms end at most this far from the middle of their doors [cells].
_LABEL_GAP_CELLS = 10
# Shorter contacts arise where labels leak through a wall that is one cell thick [cells].
_MIN_OPENING_CELLS = 10


def true_openings(truth: NDArray[np.int32], free: Mask) -> NDArray[np.float64]:
    """
    Return the places (D, 2) [row, column] where hand-labelled rooms meet across free space.

    Labels ``truth (H, W)`` are grown over ``free (H, W)``. The middle of each connected contact of
    two rooms is one opening. Rooms that do not touch give (0, 2).
    """
    filled = np.where(
        free,
        expand_labels(truth, _LABEL_GAP_CELLS),  # type: ignore[no-untyped-call]
        0,
    )
    base = int(truth.max()) + 1
    contact = np.zeros(truth.shape, dtype=np.int64)
    for axis in (0, 1):
        here = np.moveaxis(contact, axis, 0)[:-1]
        a, b = np.moveaxis(filled, axis, 0)[:-1], np.moveaxis(filled, axis, 0)[1:]
        meet = (a != b) & (a > 0) & (b > 0)
        here[meet] = (np.minimum(a, b) * base + np.maximum(a, b))[meet]
    places = []
    for pair in np.unique(contact[contact > 0]):
        stretches = grown(contact == pair, 1).astype(np.uint8)
        _, _, stats, centres = cv2.connectedComponentsWithStats(stretches, connectivity=8)
        sides = stats[1:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1)
        places.append(centres[1:, ::-1][sides >= _MIN_OPENING_CELLS])
    return np.concatenate(places) if places else np.zeros((0, 2))


def place_agreement(
    found: NDArray[np.float64], truth: NDArray[np.float64], tolerance: float
) -> Agreement:
    """
    Compare places (N, 2) with true places (M, 2), one to one, at most ``tolerance`` apart.

    All measures are 0 if either side is empty.
    """
    if len(found) == 0 or len(truth) == 0:
        return Agreement(0.0, 0.0, 0.0)
    distance = cdist(found, truth)
    rows, cols = linear_sum_assignment(np.minimum(distance, 2.0 * tolerance))
    hits = int(np.count_nonzero(distance[rows, cols] <= tolerance))
    return Agreement(hits / len(found), hits / len(truth), 2.0 * hits / (len(found) + len(truth)))
