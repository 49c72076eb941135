# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What holds for every generated pair, however it was sampled."""

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from fpnet_core.types import RegionLabel
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.pairs.pair import generate_mapped_pair

SAMPLERS = {kind: SimConfig(robot_map=kind, max_rooms=24) for kind in ('clip', 'tour')}


@pytest.mark.parametrize('kind', list(SAMPLERS))
@given(seed=st.integers(0, 2**32 - 1), index=st.integers(0, 500))
@settings(max_examples=12, deadline=None)
def test_partners_are_unique_alike_and_near(kind, seed, index):
    mapped = generate_mapped_pair(seed, index, SAMPLERS[kind])
    pair = mapped.pair
    matched = np.flatnonzero(pair.sub_labels >= 0)
    partners = pair.sub_labels[matched]

    assert len(set(partners.tolist())) == len(partners)
    for sub, plan in zip(matched, partners, strict=True):
        ours, theirs = pair.sub_graph.regions[sub], pair.plan_graph.regions[plan]
        assert ours.label is theirs.label
        gap = pair.A_plan_submap.apply(np.asarray(ours.centroid)) - theirs.centroid
        # Of a long corridor only one end may have been seen.
        reach = np.linalg.norm(np.ptp(theirs.polygon, axis=0))
        assert np.linalg.norm(gap) < (1.0 if ours.label is RegionLabel.DOOR else reach)
