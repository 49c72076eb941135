# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A plan is cut into rooms once, however many take it."""

from collections import Counter
from dataclasses import replace

import numpy as np
from PIL import Image
from planted import plan_grid
import pytest

from fpnet.exports.segmented_model import complete_model
from fpnet.plan_check import check_plan
from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.drawings.wording import said_of
from fpnet_core.localizer import create_localizer
from fpnet_core.localizer.maps import cut_of
from fpnet_core.segmentation import floorplan
from fpnet_core.sites import Site, Storey
from fpnet_core.sites.storey_plans import storey_plans
from fpnet_core.types import FREE

CONFIG = FpnetConfig()


@pytest.fixture
def cuts(monkeypatch):
    """Cells and scale of everything that is cut."""
    cuts = Counter()
    cut = floorplan._cut

    def counted(grid, scene, *others):
        cuts[grid.cells.tobytes(), round(scene.cell_m, 9)] += 1
        return cut(grid, scene, *others)

    monkeypatch.setattr(floorplan, '_cut', counted)
    return cuts


@pytest.fixture
def drawing(tmp_path):
    pixels = np.where(plan_grid().cells == FREE, 255, 0).astype(np.uint8)[::-1]
    Image.fromarray(pixels).save(tmp_path / 'sheet.png')
    return tmp_path / 'sheet.png'


def use(reading):
    """Do what commands do with a plan."""
    complete_model(reading)
    said_of(reading)
    assert check_plan(reading, CONFIG, range(0), None).segmentation is reading.segmentation
    assert cut_of(reading, CONFIG).segmentation is reading.segmentation
    localizer = create_localizer(CONFIG)
    localizer.set_storeys(storey_plans(Site('', (Storey('', reading),)), CONFIG))
    assert localizer.plan.segmentation is reading.segmentation


@pytest.mark.parametrize('length', [None, (0.0, 0.0, 200.0, 0.0, 10.0)])
def test_a_drawing_is_cut_once_at_its_scale(drawing, cuts, length):
    reading = read_plan(drawing, ReadOptions(length=length))
    found = reading.segmentation
    known = Counter(cuts)
    use(reading)
    assert cuts == known
    assert max(known[found.grid.cells.tobytes(), round(found.grid.resolution, 9)], 1) == 1
    assert (len(found.rooms), len(found.doors)) == (7, 6)


def test_another_configuration_cuts_anew(drawing, cuts):
    reading = read_plan(drawing, ReadOptions(resolution_m=0.05))
    simple = CONFIG.segmentation.model_copy(update={'method': 'distance'})
    before = sum(cuts.values())
    assert reading.segmented(simple) is not reading.segmentation
    assert replace(reading, config=simple, cut=None).segmentation.rooms
    assert sum(cuts.values()) == before + 2
