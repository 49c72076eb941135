# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Each answer's reason, word for word, and what holds of all of them."""

from dataclasses import replace
import math
import re

import numpy as np
import pytest

from fpnet_core.geometry import SE2, Affine2D, Placements
from fpnet_core.scoring import (
    CONTEXT,
    FIGURES,
    Circumstances,
    Evidence,
    Posterior,
)
from fpnet_core.scoring.reasons import (
    MIRRORED,
    reason_of,
)

WALLS_M, CLAIM = 140.0, 0.99
HERE, NORTH = SE2.from_xy_yaw(3.0, -2.0, 0.4), SE2.from_xy_yaw(3.0, 32.0, 0.4)
LOOK = Circumstances(WALLS_M, CLAIM, np.zeros((1, 2)))


def signed_log(value):
    return math.copysign(math.log1p(abs(value)), value)


def posterior(where, p, support, none=0.0, foreign=0.0, mirror=0.0, contested_m=0.0, **figures):
    """Return a verdict; each placement's rival is the one that explains most of the walls."""
    rows = np.zeros((len(where), len(FIGURES)), np.float32)
    named = {'support': support, 'bent_support': support, **figures}
    for name, values in named.items():
        rows[:, FIGURES.index(name)] = values
    bent = rows[:, FIGURES.index('bent_support')].astype(float)
    plain = np.asarray(support, float)
    for k in range(len(where) if len(where) > 1 else 0):
        rival = max((j for j in range(len(where)) if j != k), key=lambda j: bent[j])
        for name, share in (('rival_net', plain), ('rival_bent_net', bent)):
            rows[k, FIGURES.index(name)] = signed_log(WALLS_M * (share[k] - share[rival]))
        rows[k, FIGURES.index('rival_contested')] = math.log1p(contested_m)
    placements = replace_probability(Placements.of(where), p)
    evidence = Evidence(rows, np.zeros(len(CONTEXT), np.float32))
    return Posterior(placements, evidence, np.zeros(len(where)), 0.0, none, foreign, mirror)


def replace_probability(placements, p):
    return Placements(placements.linear, placements.translation, probability=p)


def scaled(factor):
    return Affine2D(factor * np.eye(2), np.zeros(2))


def test_a_claim_says_how_much_it_explains_and_how_far_the_best_rival_is_behind():
    found = posterior([HERE, NORTH], [0.995, 0.003], [0.912, 0.778])
    assert reason_of(found, replace(LOOK, is_accepted=True)) == (
        'explains 91 % of 140 m of observed wall; runner-up 34 m north: 78 %'
    )


def test_a_claim_without_a_rival_says_so():
    found = posterior([HERE], [0.999], [0.87])
    assert reason_of(found, replace(LOOK, is_accepted=True)) == (
        'explains 87 % of 140 m of observed wall; no runner-up'
    )


def test_a_claim_on_a_bent_drawing_says_by_how_much():
    found = posterior(
        [HERE, NORTH], [0.995, 0.003], [0.5, 0.3], bent_support=[0.84, 0.41],
        bend_gain=[0.34, 0.11], bend_m=[0.42, 0.4],
    )  # fmt: skip
    assert reason_of(found, replace(LOOK, is_accepted=True)) == (
        'explains 84 % of 140 m of observed wall (plan locally deformed by 0.4 m RMS); '
        'runner-up 34 m north: 41 %'
    )


def test_a_tie_says_how_much_more_wall_would_part_the_two():
    # log(0.99 / 0.01) = 4.6 nats; contested walls of 10 m have brought log(0.8 / 0.16) = 1.6.
    found = posterior([HERE, NORTH], [0.8, 0.16], [0.91, 0.88], none=0.04, contested_m=10.0)
    assert reason_of(found, LOOK) == (
        'explains 91 % of 140 m of observed wall; runner-up 34 m north: 88 %; '
        '19 m more wall where they differ would decide'
    )


@pytest.mark.parametrize(
    ('there', 'words'),
    [
        ((10.2, 0.0, 0.0), '10 m east'),
        ((7.0, 7.0, 0.0), '10 m north-east'),
        ((-12.0, 1.0, 0.0), '12 m west'),
        ((3.0, -3.2, 0.0), '4 m south-east'),
        ((0.0, -6.0, math.pi), '6 m south, rotated by 180 degrees'),
        ((0.2, 0.1, -math.pi / 2), 'rotated by 90 degrees'),
        ((0.2, 0.1, 0.1), 'at nearly the same place'),
    ],
)
def test_where_a_rival_lies(there, words):
    found = posterior([SE2.identity(), SE2.from_xy_yaw(*there)], [0.6, 0.35], [0.9, 0.89])
    assert f'runner-up {words}: 89 %' in reason_of(found, LOOK)


def test_another_building():
    found = posterior([HERE], [0.1], [0.3], none=0.2, foreign=0.7)
    assert (
        reason_of(found, LOOK) == 'explains 30 % of the observed walls: possibly another building'
    )


@pytest.mark.parametrize(
    ('held', 'words'),
    [
        ({'foreign': 0.6}, 'not enough yet to rule out another building'),
        ({'none': 0.6}, 'not enough yet to rule out another place on this plan'),
    ],
)
def test_walls_that_fit_but_are_too_few(held, words):
    found = posterior([HERE], [0.4], [0.96], **held)
    look = replace(LOOK, walls_m=45.4)
    assert reason_of(found, look) == f'explains 96 % of 45 m of observed wall: {words}'


def test_elsewhere_on_this_plan():
    found = posterior([HERE, NORTH], [0.3, 0.1], [0.62, 0.6], none=0.5, foreign=0.1)
    assert reason_of(found, LOOK) == (
        'explains 62 % of the observed walls: the robot may be elsewhere on this plan'
    )


@pytest.mark.parametrize(('mirror', 'how'), [(0.3, 'equally well'), (0.5, 'better')])
def test_a_mirror_image_that_fits(mirror, how):
    found = posterior([HERE], [0.4], [0.62], none=mirror + 0.05, mirror=mirror, foreign=0.05)
    assert reason_of(found, LOOK) == (
        f"explains 62 % of the observed walls: the floorplan's mirror image fits {how}"
    )


def test_a_mirrored_plan():
    found = posterior([HERE], [0.01], [0.3], none=0.99)
    assert reason_of(found, replace(LOOK, is_mirrored=True)) == MIRRORED


@pytest.mark.parametrize(
    ('factor', 'words'),
    [
        (1.127, 'best fit at 1.13 times the stated scale, the highest searched'),
        (0.888, 'best fit at 0.89 times the stated scale, the lowest searched'),
    ],
)
def test_a_scale_at_the_edge_of_what_was_searched_is_named(factor, words):
    look = replace(LOOK, scales=(0.887, 1.127))
    found = posterior([scaled(factor), scaled(1.0)], [0.6, 0.35], [0.9, 0.89])
    assert reason_of(found, look).endswith(words)
    assert reason_of(found, replace(look, is_accepted=True)).endswith(words)


@pytest.mark.parametrize(
    ('sure', 'missing', 'news', 'words'),
    [
        (1, 2, True, 'once, needs 2 more updates with new observations'),
        (2, 1, True, 'twice, needs 1 more update with new observations'),
        (3, 2, False, '3 times, needs 2 more updates'),
    ],
)
def test_a_sure_placement_that_is_not_confirmed(sure, missing, news, words):
    found = posterior([HERE, NORTH], [0.995, 0.003], [0.9, 0.7])
    look = replace(LOOK, sure_looks=sure, missing_looks=missing, needs_news=news)
    assert reason_of(found, look) == f'confirmed {words}'


def test_a_sure_placement_whose_mirror_image_nobody_has_looked_at():
    found = posterior([HERE], [0.995], [0.9])
    assert reason_of(found, LOOK) == (
        "probability sufficient; the floorplan's mirror image still to be checked"
    )


def test_too_little_seen():
    look = replace(LOOK, walls_m=18.2)
    foreign = posterior([HERE], [0.3], [0.9], foreign=0.7)
    assert reason_of(foreign, look) == 'only 18 m of wall observed so far'
    rival = posterior([HERE, NORTH], [0.5, 0.4], [0.9, 0.8], contested_m=5.0)
    assert reason_of(rival, look) == (
        'only 18 m of wall observed so far; runner-up 34 m north: 80 %'
    )
    assert reason_of(posterior([], [], [], none=0.5, foreign=0.5), look) == (
        'only 18 m of wall observed so far'
    )


def test_no_placement_at_all():
    found = posterior([], [], [], none=0.9, foreign=0.1)
    assert reason_of(found, LOOK) == 'the observations fit nowhere on the floorplan'


@pytest.mark.parametrize('seed', range(60))
def test_every_verdict_has_one_plain_sentence(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(0, 5))
    p = np.sort(rng.dirichlet(np.full(count + 2, rng.choice([0.05, 1.0]))))[::-1]
    where = [SE2.from_xy_yaw(*rng.normal(scale=20.0, size=3)) for _ in range(count)]
    shares = {name: rng.random(count) for name in ('bent_support', 'denied', 'bend_m')}
    found = posterior(
        where, p[:count], rng.random(count), none=p[-2], foreign=p[-1],
        contested_m=rng.exponential(20.0), bend_gain=rng.normal(scale=0.2, size=count), **shares,
    )  # fmt: skip
    look = Circumstances(
        float(rng.choice([0.0, 20.0, WALLS_M])), CLAIM, rng.normal(size=(4, 2)),
        scales=(0.9, 1.1), is_accepted=bool(rng.integers(2)), is_mirrored=bool(rng.integers(2)),
        missing_looks=int(rng.integers(3)), needs_news=bool(rng.integers(2)),
    )  # fmt: skip
    said = reason_of(found, look)
    assert said == said.strip()
    assert '\n' not in said
    assert not re.search(r'\b(nan|inf|None)\b', said)
    figures = re.findall(r'(\S+) (%|m of|m more|m north|m south|m east|m west|degrees)', said)
    assert all(number.isdigit() for number, _ in figures)
    assert all(int(number) <= 100 for number, unit in figures if unit == '%')


def test_a_plan_that_is_its_own_image_turned_is_no_other_building():
    turned = SE2.from_xy_yaw(3.0, -2.0, 0.4 + math.pi)
    found = posterior([HERE, turned], [0.3, 0.28], [0.7, 0.69], foreign=0.4)
    assert reason_of(found, LOOK) == (
        'explains 70 % of 140 m of observed wall; runner-up rotated by 180 degrees: 69 %'
    )
    foreign = posterior([HERE, turned], [0.1, 0.1], [0.7, 0.69], foreign=0.8)
    assert (
        reason_of(foreign, LOOK)
        == 'explains 70 % of the observed walls: possibly another building'
    )


def test_another_building_whose_walls_are_not_there():
    found = posterior([HERE], [0.1], [0.71], foreign=0.9, denied=[0.44])
    assert reason_of(found, LOOK) == (
        'explains 71 % of the observed walls, but 44 % of the plan walls there are missing: '
        'possibly another building'
    )


def test_a_scale_at_the_edge_may_be_why_little_is_explained():
    look = replace(LOOK, scales=(0.887, 1.127))
    found = posterior([scaled(1.127)], [0.1], [0.52], foreign=0.9)
    assert reason_of(found, look) == (
        'explains 52 % of the observed walls, at 1.13 times the stated scale, the highest '
        'searched: possibly another scale or another building'
    )
