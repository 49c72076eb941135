# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from fpnet_core.geometry import Similarity2D
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap
from fpnet_lab.baselines import correlative
from fpnet_lab.baselines.correlative import search_placement

TRUTH = Similarity2D.from_scale_yaw(1.25, np.deg2rad(40.0), [3.0, 2.0])


def drawing():
    """Return three rooms of different shape, 24 x 15 m at 0.1 m."""
    cells = np.full((170, 260), UNKNOWN, np.int8)
    for x, y, width, height in ((10, 10, 120, 60), (10, 70, 50, 80), (130, 10, 110, 100)):
        cells[y : y + height, x : x + width] = OCCUPIED
        cells[y + 2 : y + height - 2, x + 2 : x + width - 2] = FREE
    return GridMap(cells, 0.1)


def seen_from(plan, truth):
    """Return the plan as a map in a frame from which ``truth`` leads to the plan's."""
    shape = (220, 240)
    grid = GridMap(np.full(shape, UNKNOWN, np.int8), 0.1, frame='submap')
    rc = np.argwhere(np.ones(shape, dtype=bool))
    at = np.rint(plan.xy_to_rc(truth.apply(grid.rc_to_xy(rc) - [6.0, 9.0]))).astype(int)
    inside = ((at >= 0) & (at < plan.shape)).all(axis=1)
    cells = grid.cells.copy()
    cells[rc[inside, 0], rc[inside, 1]] = plan.cells[at[inside, 0], at[inside, 1]]
    shifted = Similarity2D(truth.linear, truth.apply(np.array([-6.0, -9.0])))
    return GridMap(cells, 0.1, frame='submap'), shifted


def test_a_planted_similarity_is_found(monkeypatch):
    # A tenth of the published grid: the truth lies on it, and the test stays short.
    monkeypatch.setattr(correlative, 'ROTATIONS', 9)
    plan = drawing()
    sub, truth = seen_from(plan, TRUTH)
    found = search_placement(plan, sub, np.array([0.8, 1.0, 1.25]))
    assert found is not None
    assert found.A_plan_submap.linear == pytest.approx(truth.linear, abs=1e-9)
    # Three quarters of a raster pixel, which is 0.17 m here.
    assert found.A_plan_submap.translation == pytest.approx(truth.translation, abs=0.25)
    assert 0.5 < found.score < 1.1


def test_a_map_without_walls_is_nowhere():
    plan = drawing()
    assert search_placement(plan, GridMap(np.zeros((5, 5), np.int8), 0.1)) is None
