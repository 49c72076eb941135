# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Likely causes of having no answer: their order, words and commands."""

from dataclasses import replace

import pytest

from fpnet_core.scoring.causes import causes_of
from fpnet_core.scoring.findings import (
    DoubleWalls,
    Findings,
    Fit,
    Sensed,
    TurningWalls,
    storeys_alike,
)
from fpnet_core.scoring.invocation import Invocation
from fpnet_core.segmentation import ScaleEstimate
from fpnet_core.types import CauseKind

ASKED = Invocation(
    ('fpnet', 'localize', 'my drive', '--floorplan'), 'plan.png', (('--page', '2'),)
)
POOR = Findings(
    140.0, 90.0, 400.0, 12.0, Fit(0.02, 0.55, 1.02), (0.55, 0.54), (0.9, 1.1), 0.05
)  # fmt: skip
TRIED = replace(POOR, rescaled=Fit(0.01, 0.58, 1.7), mirror=Fit(0.03, 0.56, 1.0))


def kinds(found):
    return [cause.kind for cause in causes_of(found, ASKED)]


def first(found):
    return causes_of(found, ASKED)[0]


def test_another_building_says_what_was_tried():
    assert first(TRIED).evidence == (
        'the best placement explains 55 % of 140 m of observed wall (a correct one: 80 % or '
        'more); it does not fit at other scales or mirrored either'
    )
    assert first(TRIED).next == "fpnet localize 'my drive' --floorplan OTHER_PLAN"
    assert first(POOR).evidence.endswith('(a correct one: 80 % or more)')


def test_a_sheet_of_several_storeys_offers_the_next():
    found = replace(TRIED, storeys=3, storey=1)
    assert first(found).evidence.endswith('the sheet contains 3 storeys')
    assert first(found).next == (
        "fpnet localize 'my drive' --floorplan plan.png --page 2 --storey 2"
    )


def test_a_scale_that_fits_is_what_to_type():
    found = replace(TRIED, rescaled=Fit(0.99, 0.86, 1.6))
    assert kinds(found) == [CauseKind.SCALE]
    assert first(found).evidence == (
        '86 % of 140 m of observed wall fit at 1.60 times the scale used (p 0.99); the search '
        'covered 0.90 to 1.10, and 0.0312 m per pixel would fit'
    )
    assert first(found).next == (
        "fpnet localize 'my drive' --floorplan plan.png --page 2 --resolution 0.0312"
    )
    said = Invocation(('fpnet', 'match', '--floorplan'), 'p', (('--length', '0,0,9,9=6'),))
    assert causes_of(found, said)[0].next == 'fpnet match --floorplan p --resolution 0.0312'


def test_a_mirror_image_that_fits_is_proof():
    found = replace(TRIED, mirror=Fit(0.99, 0.9, 1.0))
    assert kinds(found) == [CauseKind.MIRRORED]
    assert first(found).next.endswith('plan.png --page 2 --mirrored')
    assert first(replace(POOR, is_mirrored=True)).kind is CauseKind.MIRRORED


def test_a_drawing_that_was_flipped_in_error_is_flipped_back():
    invocation = Invocation(
        ('fpnet', 'match', '--floorplan'), 'p', (('--mirrored', ''), ('--page', '2'))
    )
    found = replace(TRIED, mirror=Fit(0.99, 0.9, 1.0))
    assert causes_of(found, invocation)[0].next == 'fpnet match --floorplan p --page 2'


@pytest.mark.parametrize('found', [POOR, TRIED, replace(TRIED, drift=TurningWalls(40.0, 30.0))])
def test_a_doubtful_reading_comes_before_every_guess(found):
    found = replace(found, doubts=('no door was found', 'one room holds 95 % of the floor'))
    assert first(found).kind is CauseKind.DRAWING
    assert first(found).evidence == 'no door was found; one room holds 95 % of the floor'
    assert first(found).next == (
        'fpnet plan plan.png --page 2 --out out/plan.yaml and look at out/plan_reading.png'
    )
    proved = replace(found, mirror=Fit(0.99, 0.9, 1.0))
    assert kinds(proved)[:2] == [CauseKind.MIRRORED, CauseKind.DRAWING]


def test_little_comes_before_places_alike():
    found = replace(POOR, walls_m=47.0, seen_m2=29.0, plan_m2=725.0, alike=(0.93, 0.92))
    found = replace(found, best=Fit(0.5, 0.93, 1.0))
    assert kinds(found) == [CauseKind.TOO_LITTLE, CauseKind.SELF_SIMILAR]


def test_little_comes_before_another_building():
    assert kinds(replace(POOR, walls_m=20.0, seen_m2=20.0)) == [CauseKind.TOO_LITTLE]
    found = replace(POOR, walls_m=40.0, seen_m2=40.0)
    assert set(kinds(found)) == {CauseKind.TOO_LITTLE, CauseKind.OTHER_PLAN}
    assert first(replace(POOR, seen_m2=9.5)).evidence == (
        '9 m² of floor observed, and the first update needs 12 m²'
    )


def test_drift_comes_before_another_building():
    double = replace(TRIED, drift=DoubleWalls(0.83, 5.7, 42.0, 0.45, 0.96))
    assert kinds(double) == [CauseKind.DRIFT, CauseKind.OTHER_PLAN]
    assert first(double).evidence == (
        'walls revisited after 42 m are displaced by 0.8 m and 6 degrees (45 % of them agree with '
        'the first pass, 96 % after correction)'
    )
    assert first(replace(TRIED, drift=TurningWalls(40.0, 30.0))).kind is CauseKind.DRIFT
    assert first(replace(TRIED, contradictions=3)).kind is CauseKind.DRIFT


def test_places_alike_are_counted():
    found = replace(TRIED, best=Fit(0.4, 0.91, 1.0), alike=(0.91, 0.9, 0.89, 0.89, 0.88))
    assert kinds(found) == [CauseKind.SELF_SIMILAR]
    assert first(found).evidence == (
        '5 places explain the 140 m of observed wall equally well: '
        '91 %, 90 %, 89 %, 89 % and 1 more'
    )
    assert first(found).next.startswith('fpnet check-plan plan.png --page 2 --plot alike.png')


def test_there_is_always_a_cause():
    assert len(causes_of(Findings(0.0, 0.0))) == 1
    fits = replace(TRIED, best=Fit(0.9, 0.9, 1.0), alike=(0.9,))
    assert 'no finding contradicts the plan' in first(fits).evidence


def test_a_scanner_upside_down_is_no_mirrored_drawing():
    found = replace(TRIED, mirror=Fit(0.99, 0.9, 1.0), sensed=Sensed(is_upside_down=True))
    assert kinds(found) == [CauseKind.UPSIDE_DOWN]
    assert first(found).next == "fpnet doctor 'my drive'"
    assert kinds(replace(found, is_mirrored=True)) == [CauseKind.UPSIDE_DOWN]


def test_storeys_that_nothing_tells_apart_are_not_another_building():
    invocation = Invocation(('fpnet', 'localize', 'drive', '--site'), 'site.yaml')
    found = replace(TRIED, storeys_alike=storeys_alike({'1': 0.45, '2': 0.44, '3': 0.01}))
    (cause,) = causes_of(found, invocation)
    assert cause.kind is CauseKind.SELF_SIMILAR
    assert cause.evidence == (
        'the observations do not separate these storeys: 1 (p 0.45), 2 (p 0.44)'
    )
    assert cause.next.endswith('fpnet localize drive --floorplan PLAN_OF_THE_STOREY')
    for unlike in ({}, {'1': 0.9}, {'1': 0.9, '2': 0.05}, {'1': 0.1, '2': 0.1}):
        assert storeys_alike(unlike) == {}


def test_rare_scans_are_the_cause_of_drift_and_of_walls_that_fit_nowhere():
    found = replace(TRIED, drift=TurningWalls(40.0, 30.0), sensed=Sensed(matched_hz=2.0))
    assert kinds(found) == [CauseKind.RARE_SCANS]
    assert first(found).evidence.startswith('2.0 scans per second, and no other odometry')
    assert first(found).next.endswith('plan.png --page 2 --poses POSES.tum')
    assert first(replace(found, sensed=Sensed(matched_hz=10.0))).kind is CauseKind.DRIFT


def test_rooms_that_deny_a_scale_leave_nothing_for_guesses():
    found = replace(TRIED, scale_conflict=ScaleEstimate(0.1, 0.08, 0.13))
    assert kinds(found) == [CauseKind.SCALE]
    assert first(found).evidence == (
        'its rooms, doors and walls suggest 0.005 m per pixel (0.004 to 0.0065); 0.05 was used'
    )
    assert first(found).next.endswith('--set localizer.scale_policy=unknown')


def test_the_edge_of_what_was_searched_is_a_hint_only():
    found = replace(POOR, best=Fit(0.02, 0.55, 1.1))
    assert kinds(found) == [CauseKind.OTHER_PLAN, CauseKind.SCALE]
    assert 'the highest searched (0.90 to 1.10)' in causes_of(found)[1].evidence


def test_what_explains_no_more_is_no_proof():
    found = replace(TRIED, mirror=Fit(0.99, 0.57, 1.0), rescaled=Fit(0.99, 0.57, 1.6))
    assert kinds(found) == [CauseKind.OTHER_PLAN]
