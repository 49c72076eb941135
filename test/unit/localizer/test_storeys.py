# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which storey the robot is on: claims name it, equal ones stay open, a word decides."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
import re

import numpy as np
from planted import A_BUILDING_PLAN, plan_grid
from planted_drive import drive, recorded
from planted_site import EvenMatcher, laid_elsewhere, other_storey
import pytest
from test_update import digest

from fpnet_core.config import load_config
from fpnet_core.errors import HintError, MapFormatError
from fpnet_core.geometry import SE2
from fpnet_core.localizer import GlobalLocalizer, Localizer, StoreyPlan
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.localizer.storeys import prepared_storeys
from fpnet_core.localizer.tracking import HypothesisTracker
from fpnet_core.localizer.update import update
from fpnet_core.localizer.update_state import Observation, UpdateState
from fpnet_core.scoring import PlacementScorer
from fpnet_core.submaps import SubmapBuilder
from fpnet_core.types import GridMap, Status

TRUE, OTHER = StoreyPlan('true', plan_grid()), StoreyPlan('other', other_storey())
EQUAL = StoreyPlan('equal', laid_elsewhere(plan_grid()))
CONFIG = load_config(None)


def new(*storeys):
    localizer = Localizer(CONFIG, EvenMatcher())
    localizer.set_storeys(storeys)
    return localizer


def run(localizer, scans=None, tick_every=5):
    outputs = []
    for index, (points, T_odom_sensor, stamp_ns) in enumerate(scans or recorded()):
        localizer.add_scan(points, T_odom_sensor, stamp_ns)
        if index % tick_every == tick_every - 1:
            outputs.append(localizer.update(stamp_ns))
    return outputs


@cache
def ended(*names):
    return run(new(*(storey for name in names for storey in (TRUE, OTHER, EQUAL) if
                     storey.name == name)))  # fmt: skip


@pytest.mark.parametrize('names', [('true', 'other'), ('other', 'true')])
def test_a_claim_names_the_storey_wherever_it_is_in_the_list(names):
    outputs = ended(*names)
    claims = [output for output in outputs if output.status is Status.LOCALIZED]
    assert claims
    assert {output.storey for output in claims} == {'true'}
    last = claims[-1]
    assert last is outputs[-1]
    assert last.storeys['true'] > 0.99 > 0.01 > last.storeys['other']
    assert last.reason.startswith('storey true: ')
    x, y, _ = drive()[-1]
    _, T_odom_sensor, _ = recorded()[-1]
    place = A_BUILDING_PLAN.apply(last.pose(T_odom_sensor).translation)
    np.testing.assert_allclose(place, (x, y), atol=0.3)


def test_the_snapshot_has_the_storey_that_its_output_is_about():
    """Though another one has won, and the next tick will be about that."""
    localizer, about = new(OTHER, TRUE), []
    for index, (points, T_odom_sensor, stamp_ns) in enumerate(recorded()):
        localizer.add_scan(points, T_odom_sensor, stamp_ns)
        if index % 5 == 4 and localizer.update(stamp_ns).storey:
            about.append((localizer.snapshot.output.storey, localizer.snapshot.plan.name))
    assert {said for said, _ in about} == {'other', 'true'}
    assert all(said == plan for said, plan in about)


def test_equal_storeys_stay_open_and_say_so():
    outputs = ended('true', 'other', 'equal')
    assert Status.LOCALIZED not in {output.status for output in outputs}
    last = outputs[-1]
    assert last.status is Status.AMBIGUOUS
    assert last.storeys['true'] == pytest.approx(last.storeys['equal'], abs=0.1)
    assert last.storeys['other'] < 0.05
    assert 'place known, storey ambiguous' in last.reason
    rival = 'equal' if last.storey == 'true' else 'true'
    assert re.search(rf'storey {rival} explains \d+ % \(p 0\.[345]\d\)', last.reason)


def test_a_word_on_the_storey_decides_between_equal_ones():
    localizer = new(TRUE, EQUAL)
    run(localizer, recorded()[:40])
    localizer.suggest_storey({'true': 0.001, 'equal': 0.999})
    outputs = run(localizer, recorded()[40:])
    assert outputs[-1].status is Status.LOCALIZED
    assert {o.storey for o in outputs if o.status is Status.LOCALIZED} == {'equal'}


def test_a_word_on_the_storey_proves_nothing():
    localizer = new(TRUE, OTHER)
    localizer.suggest_storey({'true': 0.1, 'other': 0.9})
    claims = [o for o in run(localizer) if o.status is Status.LOCALIZED]
    assert {o.storey for o in claims} == {'true'}


def hint_at(index, storey):
    """Return somebody's word on where the robot was at a scan, on the true storey's plan."""
    _, T_odom_sensor, _ = recorded()[index]
    x, y, yaw = drive()[index]
    T_plan_building = A_BUILDING_PLAN.inv()
    at = T_plan_building.apply(np.array([x, y]))
    pose = SE2.from_xy_yaw(*at.tolist(), T_plan_building.apply_yaw(yaw))
    return PoseHint(pose, SE2.from_matrix4(T_odom_sensor), storey=storey)


def test_an_initial_pose_names_its_storey():
    localizer = new(TRUE, EQUAL)
    run(localizer, recorded()[:40])
    localizer.suggest(hint_at(39, 'true'))
    assert localizer.update(recorded()[39][2]).storey == 'true'
    claims = [o for o in run(localizer, recorded()[40:]) if o.status is Status.LOCALIZED]
    assert claims
    assert {o.storey for o in claims} == {'true'}


def test_an_initial_pose_without_a_storey_is_on_the_one_in_force():
    localizer = new(TRUE, EQUAL)
    localizer.suggest_storey({'true': 0.8, 'equal': 0.2})
    before = run(localizer, recorded()[:45])
    assert before[-1].storey == 'true'
    assert before[-1].status is Status.AMBIGUOUS
    localizer.suggest(hint_at(44, ''))
    claims = [o for o in run(localizer, recorded()[45:]) if o.status is Status.LOCALIZED]
    assert claims
    assert {o.storey for o in claims} == {'true'}


def test_a_site_of_one_is_a_plan_to_the_last_bit():
    plain = Localizer(CONFIG, EvenMatcher())
    plain.set_plan(plan_grid())
    single = new(StoreyPlan('', plan_grid()))
    scans = recorded()[:60]
    for mine, theirs in zip(run(single, scans), run(plain, scans), strict=True):
        assert digest(mine) == digest(theirs)


def first_claim(outputs):
    return next(k for k, output in enumerate(outputs) if output.status is Status.LOCALIZED)


@pytest.mark.parametrize('others', [1, 4])
def test_a_claim_on_the_last_storey_comes_hardly_later_than_on_it_alone(others):
    front = (replace(OTHER, name=str(k)) for k in range(others))
    outputs = run(new(*front, TRUE), recorded()[:40])
    assert first_claim(outputs) <= first_claim(ended('true')) + 1
    assert outputs[first_claim(outputs)].storey == 'true'


@cache
def looked():
    """Each tick on a site of many: (was settled, output, floor that others were searched with)."""
    storeys = (TRUE, *(replace(OTHER, name=str(k)) for k in range(9)))
    state, told = UpdateState().on(*prepared_storeys(storeys, CONFIG)), []
    global_localizer = GlobalLocalizer(
        EvenMatcher(), PlacementScorer.configured(CONFIG.localizer), CONFIG
    )
    tracker, builder = (
        HypothesisTracker(CONFIG.localizer, global_localizer.scorer),
        SubmapBuilder(CONFIG.submap),
    )
    for index, (points, T_odom_sensor, stamp_ns) in enumerate(recorded()):
        builder.add_scan(points, T_odom_sensor, stamp_ns)
        if index % 5 == 4:
            was_settled = tracker.is_settled(state.track)
            seen = Observation(stamp_ns, builder.take(), T_odom_sensor)
            state, output = update(state, seen, global_localizer, StageTimer())
            searched_m2 = {each.plan.name: each.searched_m2 for each in state.others}
            told.append((was_settled, output, searched_m2))
    return told


def test_nothing_is_claimed_before_all_storeys_were_searched():
    first = first_claim([output for _, output, _ in looked()])
    searched = [
        min(searched_m2.values()) >= 0.5 * output.submap.free_area_m2
        for _, output, searched_m2 in looked()[: first + 1]
    ]
    assert searched[-1]
    assert not searched[0]


def test_a_settled_claim_asks_no_more_of_other_storeys_than_it_took_to_be_made():
    again, spared = 0, 0
    for (_, _, before), (was_settled, output, after) in pairwise(looked()):
        seen_m2 = output.submap.free_area_m2
        for name, searched_m2 in before.items():
            if was_settled and after[name] != searched_m2:
                assert seen_m2 >= 2.0 * searched_m2
                again += 1
            spared += was_settled and 1.05 * searched_m2 <= seen_m2 < 2.0 * searched_m2
    assert again
    assert spared > 10


@pytest.mark.parametrize('weights', [{'true': 1.0}, {'true': 1.0, 'other': 0.0}])
def test_words_must_be_of_all_storeys(weights):
    with pytest.raises(HintError):
        new(TRUE, OTHER).suggest_storey(weights)


def test_a_storey_without_rooms_is_named():
    blank = GridMap(np.full((50, 50), 100, dtype=np.int8), 0.05)
    with pytest.raises(MapFormatError, match="storey 'blank': "):
        new(TRUE, StoreyPlan('blank', blank))
    with pytest.raises(MapFormatError, match='at least one'):
        new()


def test_a_robot_that_leaves_begins_anew_where_it_may_be():
    localizer = new(TRUE, OTHER)
    run(localizer)
    localizer.leave_storey({'true': 0.5, 'other': 0.5}, 'it took the lift')
    output = localizer.output
    assert output.status is Status.WAITING
    assert output.reason == 'new submap: it took the lift'
    again = run(localizer)
    assert {o.storey for o in again if o.status is Status.LOCALIZED} == {'true'}
    assert again[0].submap.free_area_m2 < 0.5 * again[-1].submap.free_area_m2
