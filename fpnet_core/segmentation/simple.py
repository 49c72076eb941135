# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Two simple segmentations of floorplans as baselines for the default.

Both find one seed per room and grow the seeds over the free space at equal speed. "Morphological"
is the method that the paper names ([6]: Bormann et al., *Room segmentation: Survey,
implementation, and analysis*, ICRA 2016); "distance" is the same survey's threshold on the
distance transform.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import cross, shrunk, spread
from fpnet_core.segmentation.openings import Opening, find_openings
from fpnet_core.segmentation.scene import Scene, WorkRaster

# Chosen, not measured:
# A component whose area falls into this range while walls grow is a room's seed [m2].
_SEED_AREA_M2 = (0.8, 47.0)
# Step of the threshold on the distance to walls [m].
_THRESHOLD_STEP_M = 0.05
# Smaller components above the threshold are no seeds [m2].
_LEAST_SEED_M2 = 0.05

Labels = NDArray[np.int32]


def cut_rooms_simply(scene: Scene, method: str) -> tuple[Labels, list[Opening]]:
    """
    Label the rooms of a drawing by ``method``, morphological or distance.

    Returns labels and openings as :func:`fpnet_core.segmentation.rooms.cut_rooms` does.
    """
    seeds = _eroded_seeds(scene) if method == 'morphological' else _distant_seeds(scene)
    labels = spread(seeds, scene.free, cross(), seeds.size)
    work = WorkRaster(scene.free, scene.clearance, np.zeros_like(scene.free), 1, scene.cell_m)
    return labels, find_openings(labels, work, scene.free)


def _eroded_seeds(scene: Scene) -> Labels:
    """
    Return one seed per component whose area falls into the range of rooms while walls grow.

    Walls grow by one cell per step; a component that became a seed leaves the free space.
    """
    least, most = (area / scene.cell_m**2 for area in _SEED_AREA_M2)
    seeds = np.zeros(scene.free.shape, dtype=np.int32)
    rest = scene.free.astype(np.uint8)
    count = 0
    while rest.any():
        _, pieces, stats, _ = cv2.connectedComponentsWithStats(rest, connectivity=4)
        area = stats[:, cv2.CC_STAT_AREA]
        is_seed = (area >= least) & (area <= most)
        is_seed[0] = False
        number = np.where(is_seed, np.cumsum(is_seed) + count, 0)
        seeds += number[pieces].astype(np.int32)
        count += int(is_seed.sum())
        rest[is_seed[pieces]] = 0
        rest = shrunk(rest > 0, 1).astype(np.uint8)
    return seeds


def _distant_seeds(scene: Scene) -> Labels:
    """Return the components beyond the distance to walls that yields most components."""
    best = np.zeros(scene.free.shape, dtype=np.int32)
    most = 0
    for threshold in np.arange(0.0, float(scene.clearance.max()), _THRESHOLD_STEP_M):
        far = ((scene.clearance > threshold) & scene.free).astype(np.uint8)
        _, pieces, stats, _ = cv2.connectedComponentsWithStats(far, connectivity=4)
        is_seed = stats[:, cv2.CC_STAT_AREA] * scene.cell_m**2 >= _LEAST_SEED_M2
        is_seed[0] = False
        if is_seed.sum() > most:
            most = int(is_seed.sum())
            best = np.where(is_seed, np.cumsum(is_seed), 0)[pieces].astype(np.int32)
    return best
