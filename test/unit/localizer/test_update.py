# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The tick is a function: of its state and of what is seen, and of nothing else."""

from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
import hashlib
import pickle

import numpy as np
from planted import plan_grid
from planted_drive import recorded

from fpnet_core.config import load_config
from fpnet_core.geometry import SE2
from fpnet_core.localizer import GlobalLocalizer, Localizer
from fpnet_core.localizer.floorplan import Floorplan
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.localizer.update import update
from fpnet_core.localizer.update_state import Observation, UpdateState
from fpnet_core.matches import MatchResult
from fpnet_core.scoring import PlacementScorer
from fpnet_core.scoring.reasons import NO_PLAN
from fpnet_core.segmentation.moved import rescaled
from fpnet_core.submaps import SubmapBuilder
from fpnet_core.types import Status

EVERY = 5  # scans per tick
CONFIG = load_config(None, {'localizer.search_every_updates': 3})


class EvenMatcher:
    def match(self, plan, sub, explored_area_m2):
        even = np.full((len(plan), len(sub)), 0.01)
        return MatchResult(np.zeros((0, 2)), np.zeros(0), even)


def parts(value):
    """Yield the leaves of a value as bytes, but for durations."""
    if is_dataclass(value):
        for field in fields(value):
            if field.name != 'timings_ms':
                yield field.name.encode()
                yield from parts(getattr(value, field.name))
    elif isinstance(value, np.ndarray):
        yield repr((value.dtype.str, value.shape)).encode()
        yield np.ascontiguousarray(value).tobytes()
    elif isinstance(value, tuple | list):
        yield str(len(value)).encode()
        for each in value:
            yield from parts(each)
    elif isinstance(value, dict):
        yield from parts(sorted(value.items()))
    elif isinstance(value, Enum):
        yield str(value).encode()
    elif value is None or isinstance(value, bool | int | float | str | np.generic):
        yield repr(value).encode()
    else:
        raise TypeError(f'{type(value).__name__} is no plain value')


def digest(*values):
    return hashlib.sha256(b'|'.join(parts(values))).hexdigest()


@cache
def global_localizer():
    return GlobalLocalizer(EvenMatcher(), PlacementScorer.configured(CONFIG.localizer), CONFIG)


@cache
def with_hint():
    """A hint that is wrong, so that ticks with it differ from those without."""
    return PoseHint(SE2.from_xy_yaw(1.0, 2.0, 0.5), SE2.identity())


@cache
def updates():
    """Each tick of a drive on a drawing that is stated too large: (state, seen, after, output)."""
    builder = SubmapBuilder(CONFIG.submap)
    state = UpdateState(Floorplan.prepared(rescaled(plan_grid(), 1.22), CONFIG))
    made = []
    for index, (points, T_odom_sensor, stamp_ns) in enumerate(recorded()):
        builder.add_scan(points, T_odom_sensor, stamp_ns)
        if index % EVERY == EVERY - 1:
            seen = Observation(stamp_ns, builder.take(), T_odom_sensor)
            after, output = update(state, seen, global_localizer(), StageTimer())
            made.append((state, seen, after, output))
            state = after
    return made


def kinds():
    """One tick of each kind: first, last without a claim, with one, followed, searched again."""
    is_accepted = [output.status is Status.LOCALIZED for *_, output in updates()]
    claim = is_accepted.index(True)
    followed = [k for k, (state, *_) in enumerate(updates()) if state.searched is not None]
    assert 0 < claim < len(updates()) - 1
    assert followed
    return sorted({0, claim - 1, claim, followed[0], len(updates()) - 1})


def test_the_same_state_gives_the_same_answer_and_stays_as_it_was():
    for number in kinds():
        state, seen, after, output = updates()[number]
        before = digest(state, seen)
        again = update(state, seen, global_localizer(), StageTimer())
        assert digest(*again) == digest(after, output), number
        assert digest(state, seen) == before, number


def test_a_wrong_word_is_remembered_and_changes_no_claim():
    state, seen, after, output = updates()[-1]
    assert output.status is Status.LOCALIZED
    told_after, answer = update(
        state.with_hint(with_hint()), seen, global_localizer(), StageTimer()
    )
    assert answer.status is Status.LOCALIZED
    np.testing.assert_allclose(answer.A_plan_odom.matrix, output.A_plan_odom.matrix, atol=0.05)
    assert told_after.hint.is_doubted
    assert after.hint is None


def test_a_state_is_all_there_is_to_know():
    """Nothing hangs on the identity of what went before: a copy goes on like the original."""
    for number in kinds()[-2:]:
        state, seen, after, output = updates()[number]
        copies = pickle.loads(pickle.dumps((state, seen)))
        assert digest(*update(*copies, global_localizer(), StageTimer())) == digest(
            after, output
        ), number


def test_the_shell_adds_nothing():
    localizer = Localizer(CONFIG, EvenMatcher())
    localizer.set_plan(rescaled(plan_grid(), 1.22))
    outputs = []
    for index, (points, T_odom_sensor, stamp_ns) in enumerate(recorded()[: 10 * EVERY]):
        localizer.add_scan(points, T_odom_sensor, stamp_ns)
        if index % EVERY == EVERY - 1:
            outputs.append(localizer.update(stamp_ns))
    expected = [output for *_, output in updates()[: len(outputs)]]
    assert [digest(output) for output in outputs] == [digest(output) for output in expected]


def test_without_a_plan_or_a_submap_the_state_stays():
    state, seen, *_ = updates()[-1]
    nowhere = UpdateState()
    after, output = update(nowhere, seen, global_localizer(), StageTimer())
    assert after is nowhere
    assert (output.status, output.reason, output.stamp_ns) == (
        Status.NO_PLAN,
        NO_PLAN,
        seen.now_ns,
    )
    after, output = update(state, Observation(7), global_localizer(), StageTimer())
    assert after is state
    assert (output.status, output.stamp_ns) == (Status.WAITING, 7)
