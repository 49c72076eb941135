# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot's map is one by its grey levels, however the picture was packed."""

import cv2
import numpy as np
from plan_pictures import WHITE, storey
import pytest

from fpnet_core.drawings.pictures.robot_maps import commonest_levels, map_cells
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


@pytest.mark.parametrize('paper', [222, 232, 239])
@pytest.mark.parametrize('noise', [3.0, 5.0])
def test_shades_of_tinted_paper_are_one_level(paper, noise):
    picture, _ = storey()
    rng = np.random.default_rng(0)
    grey = np.where(picture[..., 0] == WHITE, paper, picture[..., 0]).astype(float)
    # A scanner's noise is coarser than a pixel.
    coarse = cv2.resize(rng.normal(0.0, noise, (90, 120)), grey.shape[::-1])
    tinted = np.clip(grey + coarse, 0, 255).astype(np.uint8)
    assert map_cells(packed(np.repeat(tinted[..., None], 3, axis=2), 85), 0.05) is None


@pytest.mark.parametrize('spacing', [1, 2, 3])
@pytest.mark.parametrize('noise', [1.0, 5.0, 8.0])
def test_no_pixel_counts_for_two_levels(spacing, noise):
    rng = np.random.default_rng(1)
    grey = np.where(rng.random((200, 200)) < 0.1, 20.0, 225.0) + rng.normal(0.0, noise, (200, 200))
    grey = np.clip(np.round(grey / spacing) * spacing, 0, 255).astype(np.uint8)
    levels = commonest_levels(grey)
    assert sum(share for _, share in levels) <= 1.0 + 1e-9
    near_paper = [
        level for level, share in levels if abs(level - 225) < 3 * noise and share > 0.01
    ]
    assert len(near_paper) == 1
