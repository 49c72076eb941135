# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A drawing's scale, where only its doors, rooms and walls tell."""

import numpy as np
import pytest

from fpnet_core.drawings.estimated_scale import drawing_scale, estimate_scale
from fpnet_core.drawings.types import ScaleSource
from fpnet_core.segmentation import ScaleEstimate
from fpnet_core.types import FREE, OCCUPIED, GridMap, Portal, Region, RegionLabel, Segmentation


def segmentation():
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    regions = (
        Region(0, RegionLabel.ROOM, square, square.mean(0), 16.0),
        Region(1, RegionLabel.DOOR, square, square.mean(0), 0.2),
    )
    portal = Portal(1, (0, None), np.array([[0.0, 0.0], [0.9, 0.0]]))
    cells = np.pad(np.full((80, 80), FREE), 4, constant_values=OCCUPIED)
    labels = (cells == FREE).astype(np.int32)
    return Segmentation(GridMap(cells, 0.05), labels, regions, (portal,))


def test_an_estimate_is_in_metres_per_pixel():
    scale = drawing_scale(ScaleEstimate(2.0, 1.5, 3.0), segmentation())
    assert (scale.resolution_m, scale.low_m, scale.high_m) == pytest.approx((0.1, 0.075, 0.15))
    assert scale.source is ScaleSource.ESTIMATED
    assert not scale.is_known
    assert scale.why == '1 door, 1 room and walls'


def test_a_segmented_drawing_has_an_interval_around_its_scale():
    scale = estimate_scale(segmentation())
    assert 0.0 < scale.low_m < scale.resolution_m < scale.high_m
