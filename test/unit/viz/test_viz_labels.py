# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import numpy as np
import pytest
from shapely import make_valid
from shapely.geometry import Point, Polygon

from fpnet.viz.segmentation import label_xy
from fpnet_core.types import Region, RegionLabel

CORRIDOR = [[0, 0], [10, 0], [10, 2], [2, 2], [2, 10], [0, 10]]
SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4]]
CROSSED = [[0, 0], [4, 4], [4, 0], [0, 4]]


@pytest.mark.parametrize('polygon', [CORRIDOR, SQUARE, CROSSED])
def test_a_name_is_written_inside_its_room(polygon):
    vertices = np.array(polygon, dtype=float)
    region = Region(0, RegionLabel.ROOM, vertices, vertices.mean(axis=0), 9.0)
    assert make_valid(Polygon(polygon)).contains(Point(label_xy(region)))
