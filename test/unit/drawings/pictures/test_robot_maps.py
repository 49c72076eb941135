# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot's map is one by its grey levels, however the picture was packed."""

import cv2
import numpy as np
from plan_pictures import WHITE, storey
import pytest

from fpnet_core.drawings.pictures.robot_maps import map_cells
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN


def packed(picture, quality):
    done, data = cv2.imencode('.jpg', picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
    assert done
    return cv2.imdecode(data, cv2.IMREAD_COLOR)


@pytest.mark.parametrize('quality', [100, 95, 85])
def test_a_packed_map_is_one(quality):
    picture, labels = storey()
    picture[(picture[..., 0] == WHITE) & (labels == 0)] = 205
    cells = map_cells(packed(picture, quality), 0.05)
    assert cells is not None
    assert {OCCUPIED, FREE, UNKNOWN} == set(np.unique(cells).tolist())
