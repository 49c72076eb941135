# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The tick is a function: of its state and of what is seen, and of nothing else."""

from dataclasses import fields, is_dataclass, replace
from enum import Enum
from functools import cache
import hashlib
import pickle

import numpy as np
from planted import plan_grid
from planted_drive import recorded
import pytest

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


def test_a_word_changes_the_answer_and_not_the_state_it_is_added_to():
    state, seen, _, output = updates()[-1]
    before, hinted = digest(state), state.unlocalized().with_hint(with_hint())
    answers = [update(hinted, seen, global_localizer(), StageTimer()) for _ in range(2)]
    assert digest(state) == before
    assert digest(*answers[0]) == digest(*answers[1])
    assert digest(answers[0][1]) != digest(output)


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


def test_each_tick_goes_on_from_what_the_last_one_left():
    digests = [digest(state) for state, *_ in updates()]
    assert len(set(digests)) == len(digests)
    state, seen, _, output = updates()[kinds()[2]]
    fresh, first = update(UpdateState(state.plan), seen, global_localizer(), StageTimer())
    assert output.status is Status.LOCALIZED
    assert first.status is not Status.LOCALIZED
    assert fresh.track.wins == 1


def test_ticks_go_on_from_all_placements_that_were_judged():
    """The judge has learned from all that a search finds; followed ones are asked of alike."""
    assert max(len(output.estimates) for *_, output in updates()) > 8
    for *_, after, output in updates():
        assert len(after.tracked) == len(output.estimates)


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


@pytest.mark.parametrize('begin', [UpdateState.unlocalized, UpdateState.without_submap])
def test_a_beginning_keeps_the_plan_with_its_scale_and_its_mirror_image(begin):
    *_, after, _ = updates()[-1]
    assert after.plan.mirror is not None
    assert after.plan.scale.is_beyond_stated
    begun = begin(after)
    assert begun.plan is after.plan
    assert begun.track.leader is begun.searched is begun.hint is None
    assert len(begun.tracked) == 0
    assert (begun.segmenter is after.segmenter) == (begin is UpdateState.unlocalized)


def test_a_word_is_kept_in_working_metres():
    unknown = load_config(None, {'localizer.scale_policy': 'unknown'})
    plan = Floorplan.prepared(rescaled(plan_grid(), 2.5), unknown)
    state = UpdateState(plan).with_hint(with_hint())
    np.testing.assert_allclose(
        state.hint.T_plan_base.translation, plan.factor * with_hint().T_plan_base.translation
    )
    np.testing.assert_array_equal(
        state.tracked[0].A_plan_submap.matrix, state.hint.A_plan_odom.matrix
    )
    assert UpdateState().with_hint(with_hint()).hint == with_hint()


def test_who_was_contradicted_too_often_is_elsewhere():
    state, seen, after, _ = updates()[-1]
    assert not after.is_elsewhere
    walls = seen.submap.newest_xy
    middle = walls.mean(axis=0)
    turned = SE2.from_xy_yaw(1.0, 0.7, 0.6).apply(walls - middle) + middle
    seen = replace(seen, submap=replace(seen.submap, newest_xy=turned, newest_walls_xy=turned))
    for doubt in range(1, CONFIG.localizer.doubt_updates + 1):
        state, output = update(state, seen, global_localizer(), StageTimer())
        assert output.status is Status.LOST
        assert state.kidnap_state.doubts == doubt
    assert state.is_elsewhere
