# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Long runs keep what each tick says, and maps of as many ticks as memory is given."""

import numpy as np
from planted import plan_grid
from planted_drive import recorded
import pytest

from fpnet.report.moments import shown_updates
from fpnet_core.config import load_config
from fpnet_core.io.scans import Scan
from fpnet_core.localizer import Replay, create_localizer
from fpnet_core.localizer.diagnosis import explain_run
from fpnet_core.localizer.kept import is_brief
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.types import CauseKind

CONFIG = load_config()
TICK_S = 0.5


def run_on(plan, **kept):
    """Return the outputs as each tick gave them, and the run at its end."""
    localizer = create_localizer(CONFIG)
    localizer.set_plan(plan)
    scans = [Scan(stamp, points, T_odom_sensor=pose) for points, pose, stamp in recorded()]
    run = Replay(scans, localizer, TICK_S, None, **kept)
    return list(run), run.result()


def bytes_of(outputs):
    whole = [each for each in outputs if not is_brief(each)]
    submaps = [each.submap for each in whole]
    maps = [s.grid.cells.nbytes + s.lintel.nbytes for s in submaps]
    return sum(maps) + sum(each.segmentation.labels.nbytes for each in whole if each.segmentation)


@pytest.fixture(scope='module')
def thinned():
    given, _ = run_on(plan_grid())
    limit = bytes_of(given[-1:]) * 6
    return limit, *run_on(plan_grid(), map_bytes=limit)


def test_maps_take_no_more_memory_than_they_are_given(thinned):
    limit, given, run = thinned
    assert bytes_of(given) > 2 * limit
    assert bytes_of(run.outputs) <= limit


def test_what_each_tick_said_is_kept(thinned):
    _, given, run = thinned
    assert [each.said for each in run.outputs] == [each.said for each in given]
    for kept, full in zip(run.outputs, given, strict=True):
        assert kept.timings_ms == full.timings_ms
        assert kept.estimates.score[:1].tolist() == full.estimates.score[:1].tolist()
        assert kept.submap.path_xy[-1].tolist() == full.submap.path_xy[-1].tolist()
    assert run.outputs[-1] is given[-1]


def test_ticks_with_maps_are_spread_over_the_run(thinned):
    _, _, run = thinned
    shown = shown_updates(run.outputs)
    assert all(not is_brief(run.outputs[index]) for index in shown)
    assert shown[0] == 0
    assert shown[-1] == len(run.outputs) - 1
    assert np.diff(shown).max() <= len(run.outputs) / 2


def test_causes_are_told_from_what_is_kept():
    plan = plan_grid().mirrored()
    given, _ = run_on(plan)
    _, run = run_on(plan, map_bytes=bytes_of(given[-1:]) * 3)
    matcher = LearnedMatcher(CONFIG.matcher)
    told = [explain_run(each, plan, matcher, CONFIG) for each in (given, run.outputs)]
    assert [cause.said for cause in told[0]] == [cause.said for cause in told[1]]
    assert told[0][0].kind is CauseKind.MIRRORED
