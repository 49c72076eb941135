# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The model that tells doors from lines inside of rooms, and what the packaged one says."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.errors import WeightsError
from fpnet_core.geometry import SE2
from fpnet_core.io.weights import read_weights
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.segmentation.door_model import (
    DOOR_NAME,
    DOOR_SCHEMA,
    model_of,
)
from fpnet_core.types import FREE, OCCUPIED, GridMap

CELL_M = 0.05


def test_weights_for_other_figures_are_refused():
    weights = read_weights(None, DOOR_SCHEMA, DOOR_NAME)
    network = {**weights.manifest['network'], 'figures': ['width']}
    other = replace(weights, manifest={**weights.manifest, 'network': network})
    with pytest.raises(WeightsError, match='train doors'):
        model_of(other)


def corridor(left_m, right_m, frame_m, angle_deg):
    """Two lengths of free space, 8 m each, of two widths, joined by a frame 0.3 m deep."""
    T = SE2.from_xy_yaw(12.0, 12.0, np.radians(angle_deg))
    cells = np.full((480, 480), OCCUPIED, np.uint8)
    for x0, x1, width in ((-8.0, -0.15, left_m), (0.15, 8.0, right_m), (-0.2, 0.2, frame_m)):
        y = width / 2.0
        corners = T.apply(np.array([[x0, -y], [x1, -y], [x1, y], [x0, y]])) / CELL_M - 0.5
        cv2.fillPoly(cells, [np.rint(corners * 16).astype(np.int32)], int(FREE), shift=4)
    return GridMap(cells.astype(np.int8), CELL_M)


@pytest.mark.parametrize('angle_deg', [0.0, 20.0, 90.0])
def test_a_corridor_with_a_frame_is_one_room_and_with_a_door_two(angle_deg):
    counts = [
        len(segment_floorplan(corridor(1.8, 1.8, frame, angle_deg), SegmentationConfig()).rooms)
        for frame in (1.7, 0.9)
    ]
    assert counts == [1, 2]
