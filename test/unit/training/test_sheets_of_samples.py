# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Generated sheets as a user's reader sees them."""

import numpy as np
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.types import FREE
from fpnet_lab.sim.sheets import SheetKind, draw_sheet
from fpnet_lab.training.scale_samples import FIRST_SHEET
from fpnet_lab.training.sheets_read import read_from_file


@pytest.fixture(scope='module')
def read():
    return read_from_file(draw_sheet(FIRST_SHEET, SheetKind.CLEAN), SegmentationConfig())


def test_what_is_read_is_as_large_as_the_building(read):
    grid = read.in_true_metres
    free_m2 = (grid.cells == FREE).sum() * grid.resolution**2
    true_m2 = sum(storey.on_page.floor_area_m2 for storey in read.sheet.storeys)
    assert free_m2 == pytest.approx(true_m2, rel=0.15)


def test_it_is_larger_where_its_scale_is_estimated_too_small(read):
    nominal = read.found.segmentation.grid
    assert read.in_true_metres.shape == nominal.shape
    assert not np.isclose(read.in_true_metres.resolution, nominal.resolution, rtol=1e-3)
