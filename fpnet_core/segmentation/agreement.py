# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Agreement of a segmentation with a hand-labelled one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# Given: regions up to this size are drawing noise [cells], as in Bormann's comparison.
_NOISE_CELLS = 100
# Given: a found and a hand-drawn room match above this intersection over union, as in PASCAL VOC.
SAME_ROOM_IOU = 0.5


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
