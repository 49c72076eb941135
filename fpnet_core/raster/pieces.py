# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Connected pieces of masks."""

from __future__ import annotations

import cv2
import numpy as np

from fpnet_core.raster.morphology import Mask


def longer_pieces(mask: Mask, length: float) -> Mask:
    """Return ``mask (H, W)`` without pieces of at most ``length`` cells along both axes."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    keep = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1) > length
    keep[0] = False
    return np.asarray(keep[labels])
