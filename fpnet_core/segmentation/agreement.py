# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Agreement of a segmentation with a hand-labelled one."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist
from skimage.segmentation import expand_labels

from fpnet_core.raster.morphology import Mask, grown

# Given: regions up to this size are drawing noise [cells], as in Bormann's comparison.
_NOISE_CELLS = 100
# Chosen, not measured:
# A found and a hand-drawn room match above this intersection over union.
SAME_ROOM_IOU = 0.5
# Hand-drawn rooms end at most this far from the middle of their doors [cells].
_LABEL_GAP_CELLS = 10
# Shorter contacts arise where labels leak through a wall that is one cell thick [cells].
_MIN_OPENING_CELLS = 10


@dataclass(frozen=True)
class Agreement:
    """Precision, recall and F1, each in [0, 1]; each function defines them."""

    precision: float
    recall: float
    f1: float


def room_agreement(found: NDArray[np.int32], truth: NDArray[np.int32]) -> Agreement:
    """
    Compare room labels (H, W), 0 outside.

    Precision is the mean over found rooms of the share in one true room, recall the mean over true
    rooms of the share in one found room (Bormann et al., 2016). They forgive over- and
    under-segmentation, so ``f1`` is the harmonic mean of the shares of rooms with a partner of
    intersection over union above one half. Without rooms all are 0.
    """
    overlap = np.zeros((int(truth.max()) + 1, int(found.max()) + 1), dtype=np.int64)
    np.add.at(overlap, (truth.ravel(), found.ravel()), 1)
    rows = np.flatnonzero(overlap.sum(axis=1)[1:] > _NOISE_CELLS) + 1
    cols = np.flatnonzero(overlap.sum(axis=0)[1:] > _NOISE_CELLS) + 1
    if rows.size == 0 or cols.size == 0:
        return Agreement(0.0, 0.0, 0.0)
    size_true, size_found = overlap.sum(axis=1)[rows], overlap.sum(axis=0)[cols]
    best_true, best_found = overlap[rows, 1:].max(axis=1), overlap[1:, cols].max(axis=0)
    both = overlap[np.ix_(rows, cols)]
    iou = both / (size_true[:, None] + size_found[None, :] - both)
    hits = np.count_nonzero(iou > SAME_ROOM_IOU)
    return Agreement(
        float(np.mean(best_found / size_found)),
        float(np.mean(best_true / size_true)),
        2.0 * hits / (rows.size + cols.size),
    )


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
