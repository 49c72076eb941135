# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Methods by name that register two maps by their rasters, without regions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
import time

import numpy as np

from fpnet_core.localizer.maps import MapMatch
from fpnet_lab.baselines.answer import Answer
from fpnet_lab.baselines.branch_and_bound import BranchAndBound
from fpnet_lab.baselines.cloud_registration import CLOUD_METHODS
from fpnet_lab.baselines.correlative import search_placement
from fpnet_lab.evaluation.matching import Prediction

CLAIMS_ALL = 'correlative'
"""Given: method that accepts every result; it is not run on other buildings' plans."""


def predict_by_raster(name: str, match: MapMatch) -> Prediction:
    """Return the prediction of a method of :data:`RASTER_METHODS`, in the metres of both maps."""
    start = time.perf_counter()
    found = RASTER_METHODS[name](match)
    elapsed_ms = 1e3 * (time.perf_counter() - start)
    matrix = None if found is None else found.A_plan_submap.matrix.tolist()
    return Prediction([], [], matrix, found is not None and found.is_accepted, elapsed_ms)


def _correlative(match: MapMatch) -> Answer | None:
    found = search_placement(match.plan.segmentation.grid, match.sub.segmentation.grid)
    return None if found is None else Answer(found.A_plan_submap, found.score, is_accepted=True)


def _branch_and_bound(match: MapMatch) -> Answer | None:
    """Search the same scales as the localizer."""
    scales = np.unique(match.search.factors)
    return BranchAndBound(match.plan.evidence, scales).place(match.sub.evidence)


def _by_cloud(name: str, match: MapMatch) -> Answer | None:
    place = CLOUD_METHODS[name](match.plan.segmentation.grid)
    return place(match.sub.segmentation.grid)


RASTER_METHODS: Mapping[str, Callable[[MapMatch], Answer | None]] = {
    CLAIMS_ALL: _correlative,
    'branch_and_bound': _branch_and_bound,
    **{name: partial(_by_cloud, name) for name in CLOUD_METHODS},
}
"""Placement of a robot map on a plan, by method name."""
