# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pair sets of the matching benchmark: generated on demand from presets, or loaded."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fpnet_core.errors import FpnetError
from fpnet_core.io.maps import read_map
from fpnet_lab.sim.pairs.dataset import PairDataset
from fpnet_lab.sim.pairs.pair import MatchingPair, generate_pair
from fpnet_lab.sim.pairs.presets import in_split, preset
from fpnet_lab.sim.plans.sources import GivenPlans, find_plans

SEED = 9001
"""Numerical: seed of the benchmark's pairs; training data sets must use another one."""

REAL_PLAN_M = 0.05
"""Given: pixel size of the real floorplans, as published."""

PRESETS = {
    'tours': 'default',
    'synthetic': 'paper-synthetic',
    'real': 'paper-real',
    'challenging': 'paper-challenging',
}
"""Sampler preset of each set."""

DEFAULT_PAIRS = 200  # chosen


def stored_pairs(folder: Path, limit: int | None) -> list[MatchingPair]:
    """Return the pairs of a data set, or the first ``limit``."""
    dataset = PairDataset(folder)
    count = min(limit or len(dataset), len(dataset))
    return [dataset.pair(index) for index in range(count)]


def generated_pairs(
    name: str, plans: Path | None, split: str, limit: int | None
) -> Iterator[MatchingPair]:
    """
    Generate the pairs of the set ``name``, distributed evenly over its plans.

    Raises
    ------
    FpnetError
        If the set needs real floorplans and none are given, or a plan is unusable.
    """
    chosen = preset(PRESETS[name])
    source = None
    if chosen.needs_plans:
        if plans is None:
            raise FpnetError(f'the set {name} uses real floorplans; give --plans FOLDER')
        drawn = [(path.stem, read_map(path, REAL_PLAN_M)) for path in find_plans([plans])]
        source = GivenPlans(in_split(drawn, split), chosen.config.segmentation)
    total = chosen.pair_count(0 if source is None else len(source)) or DEFAULT_PAIRS
    count = min(limit or DEFAULT_PAIRS, total)
    for index in np.linspace(0, total - 1, count).round().astype(int).tolist():
        yield generate_pair(SEED, index, chosen.config, source)
