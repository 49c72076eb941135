# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Areas, sizes, names and numbers in rooms: what they say, and the scale that they agree on."""

from dataclasses import replace
import math

import numpy as np
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.lengths import areas, ratios, room_sizes, without_area
from fpnet_core.drawings.pictures.hypothesis import PlanHypothesis
from fpnet_core.drawings.room_texts import PrintedRoom, printed_of_rooms, room_votes
from fpnet_core.drawings.scaling import resolve_scale
from fpnet_core.drawings.stated import SaidScale
from fpnet_core.drawings.types import DrawingScale, Label, ScaleSource
from fpnet_core.drawings.votes import Prior, Vote, VoteKind, most_likely
from fpnet_core.segmentation import segment_unknown_scale
from fpnet_core.types import FREE, OCCUPIED, GridMap

RESOLUTION = 0.031
SIZES_M = ((3.2, 2.8), (5.1, 4.3), (7.4, 2.9), (2.1, 1.7), (4.6, 6.2), (3.9, 3.9), (8.8, 5.0))


def label(text, x, y, height=12.0):
    half = 0.3 * height * len(text)
    return Label(text, (x - half, y - height / 2, x + half, y + height / 2))


def storey(texts_of):
    """Return rooms beside each other and what ``texts_of`` (width, height) [m] prints in them."""
    rooms, labels, x = np.zeros((260, 1300), np.int32), [], 10
    for number, (width_m, height_m) in enumerate(SIZES_M):
        width, height = round(width_m / RESOLUTION), round(height_m / RESOLUTION)
        rooms[20 : 20 + height, x : x + width] = number + 1
        for line, text in enumerate(texts_of(width_m, height_m)):
            labels.append(label(text, x + width / 2, 20 + height / 2 + 18 * (line - 0.5)))
        x += width + 6
    return labels, rooms


def feet(metres):
    inches = round(metres / 0.0254)
    return f'{inches // 12}\'-{inches % 12}"'


WAYS = {
    'point': lambda w, h: [f'{w * h:.1f} m2'],
    'comma': lambda w, h: ['Office', f'{w * h:.2f} m²'.replace('.', ',')],
    'whole': lambda w, h: [f'{w * h:.0f} m2'],
    'named': lambda w, h: [f'NGF {w * h:.1f}'],
    'square feet': lambda w, h: [f'{w * h / 0.3048**2:.0f} sq ft'],
    'sqft': lambda w, h: [f'Bedroom {w * h / 0.3048**2:.0f} sqft'],
    'cm without unit': lambda w, h: [f'{100 * w:.0f} x {100 * h:.0f}'],
    'metres': lambda w, h: [f'{h:.2f} \u00d7 {w:.2f} m'],
    'metres without unit': lambda w, h: [f'{w:.2f} x {h:.2f}'.replace('.', ',')],
    'feet and inches': lambda w, h: [f'{feet(w)} x {feet(h)}'],
}


@pytest.mark.parametrize('way', WAYS)
def test_areas_and_sizes_in_every_notation_agree_on_the_scale(way):
    found = most_likely(room_votes(*storey(WAYS[way])))
    assert found is not None
    assert found.resolution_m == pytest.approx(RESOLUTION, rel=0.012)
    assert found.low_m < RESOLUTION < found.high_m
    assert found.high_m / found.low_m < 1.12


def test_a_few_wrong_areas_are_outvoted_and_all_wrong_ones_say_nothing():
    labels, rooms = storey(lambda w, h: [f'{w * h:.1f} m2'])
    slips = [Label('190 m2', labels[0].box)]
    found = most_likely(room_votes([*slips, *labels[1:]], rooms))
    assert found.resolution_m == pytest.approx(RESOLUTION, rel=0.01)
    assert found.why == '6 room areas agree within 1 %'
    wrong = [Label(one.text, other.box) for one, other in zip(labels, labels[::-1], strict=True)]
    assert most_likely(room_votes(wrong, rooms)) is None


def cast(log_scales, kind=VoteKind.AREA, first=0):
    return [
        Vote(scale, kind, 2.0 + 0.3 * number, first + number, '', 0.01)
        for number, scale in enumerate(log_scales)
    ]


def test_texts_that_contradict_each_other_say_nothing():
    scale = math.log(RESOLUTION)
    votes = [*cast([scale] * 8), *cast([scale + 0.4] * 7, VoteKind.DIMENSION, first=20)]
    assert most_likely(votes) is None
    assert most_likely(votes[:8]) is not None
    near = [*votes[:8], *cast([scale + 0.01] * 7, VoteKind.DIMENSION, first=20)]
    assert most_likely(near) is not None


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('13 m2', [13.0]), ('13,2 m²', [13.2]), ('NGF 13.2', [13.2]), ('Office 13.2 m2', [13.2]),
        ('142 sq ft', [13.192]), ('142 sqft', [13.192]), ('1,250 sq ft', [0.116, 116.129]),
        ('2.14', []), ('4.012', []), ('13 m', []), ('3 m 2nd floor', []), ('', []),
    ],
)  # fmt: skip
def test_areas_that_a_text_says(text, expected):
    assert list(areas(text)) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('325 x 285', [(3.25, 2.85, 'cm'), (0.325, 0.285, 'mm')]),
        ('3.25 x 2.85 m', [(3.25, 2.85, '')]),
        ("17' x 11'", [(5.1816, 3.3528, '')]),
        ('12\'-6" x 10\'-0"', [(3.81, 3.048, '')]),
        ("17'-4 x 11'-2", [(5.2832, 3.4036, '')]),
        ('Kitchen 3,25 m \u00d7 2,85 m', [(3.25, 2.85, '')]),
        ('2.14', []),
        ('1x2', []),
        ('12 x', []),
    ],
)
def test_sizes_that_a_text_says(text, expected):
    found = list(room_sizes(text))
    assert [unit for *_, unit in found] == [unit for *_, unit in expected]
    assert [side for each in found for side in each[:2]] == pytest.approx(
        [side for each in expected for side in each[:2]]
    )


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('1/4 inch = 1 ft', [48.0]), ('1/4" = 1\'-0"', [48.0]), ('1/8"=1\'', [96.0]),
        ('Scale: 1/4 inch to 1 ft', [48.0]), ('1" = 20\'', [240.0]), ('M 1:50', [50.0]),
        ('1:100', [100.0]), ('1:37', []), ('15.07.2016', []), ('1/4"', []),
    ],
)  # fmt: skip
def test_ratios_that_a_text_states(text, expected):
    assert list(ratios(text)) == pytest.approx(expected)


def test_endless_texts_take_no_time():
    for text in ('1' + ' ' * 300_000 + 'x', '1,' * 200_000, "1'" + ' ' * 300_000, '9' * 300_000):
        assert list(areas(text)) == list(room_sizes(text)) == list(ratios(text)) == []
        assert without_area(text) == text[:160].strip()[:80].strip()


def test_names_numbers_and_areas_of_rooms():
    rooms = np.zeros((200, 700), np.int32)
    for number in range(6):
        rooms[10:190, 10 + 110 * number : 110 + 110 * number] = number + 1
    texts = {
        0: ['2.14', 'Office', '13.2 m2'],
        1: ['Meeting room', 'A-103'],
        2: ['3.25', '325 x 285', '1:100', '3.5 m'],
        3: ['2.016 Server 9 m2'],
        4: ['12.0 m2', '8.0 m2'],
    }
    labels = [
        label(text, 60 + 110 * room, 60 + 20 * line, 6.0)
        for room, lines in texts.items()
        for line, text in enumerate(lines)
    ]
    assert printed_of_rooms(labels, rooms) == (
        PrintedRoom(1, 'Office', '2.14', 13.2),
        PrintedRoom(2, 'Meeting room', 'A-103'),
        PrintedRoom(3, '', '3.25'),  # a bare number may be a room's
        PrintedRoom(4, 'Server', '2.016', 9.0),
    )
    assert printed_of_rooms([], rooms) == ()
    assert without_area('Office 13.2 m2') == 'Office'


def flat(factor=1.0):
    """Return cells (H, W) of 5 cm of six rooms with doors onto a corridor."""
    cells = np.full((240, 420), OCCUPIED, np.int8)
    cells[100:136, 8:412] = FREE
    boxes = []
    for k, width in enumerate((90, 120, 170)):
        left = 8 + (0, 96, 222)[k]
        for top, height, door in ((8, 86, 94), (142, 90 - 10 * k, 136)):
            cells[top : top + height, left : left + width] = FREE
            cells[door : door + 6, left + 20 : left + 38] = FREE
            boxes.append((left, top, width, height))
    labels = [
        label(f'{w * h * (0.05 * factor) ** 2:.1f} m2', left + w / 2, top + h / 2, 5.0)
        for left, top, w, h in boxes
    ]
    return cells, tuple(labels)


def found_with(said, cells):
    segmentation, _ = segment_unknown_scale(GridMap(cells[::-1], 0.05), SegmentationConfig())
    return PlanHypothesis(cells, np.eye(3), segmentation, said)


def test_areas_go_before_doors_and_the_user_before_areas():
    config = SegmentationConfig()
    cells, labels = flat(1.3)
    scale, cell_m = resolve_scale(found_with(SaidScale(labels=labels), cells), config)
    assert scale.source is ScaleSource.ROOM_TEXTS
    assert cell_m == pytest.approx(0.065, rel=0.03)
    assert scale.low_m < 0.065 < scale.high_m
    assert '6 room areas agree' in scale.why
    bare, _ = resolve_scale(found_with(SaidScale(), cells), config)
    assert bare.source is ScaleSource.ESTIMATED
    stated = DrawingScale(0.05, 0.05, 0.05, ScaleSource.STATED)
    assert resolve_scale(found_with(SaidScale(stated), cells), config)[0] is stated
    # Another of the drawing's own texts against six areas: nobody is believed.
    bar = DrawingScale(0.09, 0.089, 0.091, ScaleSource.SCALE_BAR)
    denied, _ = resolve_scale(found_with(SaidScale(bar, labels=labels), cells), config)
    assert denied.source is ScaleSource.ESTIMATED
    alike = DrawingScale(0.065, 0.0645, 0.0655, ScaleSource.SCALE_BAR)
    assert resolve_scale(found_with(SaidScale(alike, labels=labels), cells), config)[0] is alike


def test_two_areas_in_one_space_are_those_of_its_parts():
    share = iter(np.linspace(0.1, 0.45, len(SIZES_M)))

    def parts(width_m, height_m):
        part = next(share)
        return [f'{k * width_m * height_m:.1f} m2' for k in (part, 1.0 - part)]

    found = most_likely(room_votes(*storey(parts)), Prior(math.log(0.9 * RESOLUTION), 0.12))
    assert found.resolution_m == pytest.approx(RESOLUTION, rel=0.012)


@pytest.mark.parametrize(
    'number', [lambda k: f'2.{k:02d}', lambda k: f'4.{k:03d}', lambda k: str(112 + k)]
)
def test_numbers_of_rooms_are_no_areas(number):
    count = iter(range(99))
    assert room_votes(*storey(lambda w, h: [number(next(count)), 'Office'])) == []


def test_what_no_room_surrounds_votes_for_nothing():
    _, rooms = storey(lambda w, h: [])
    assert room_votes([], rooms) == []
    assert room_votes([label('13 m2', 600, 250), label('13 m2', -50, -50)], rooms) == []
    assert room_votes([label('13 m2', 40, 40)], np.zeros_like(rooms)) == []


def test_another_unit_on_the_same_sheet_is_no_contradiction():
    scale, votes = math.log(RESOLUTION), []
    for number, value_m in enumerate((2.1, 3.4, 4.9, 6.2, 2.8, 3.9, 5.5, 7.3, 8.4, 9.6)):
        is_cm = number % 3
        for unit, factor in (('cm', 1.0), ('mm', 0.1)) if is_cm else (('cm', 10.0), ('mm', 1.0)):
            off = scale + math.log(factor)
            votes.append(Vote(off, VoteKind.DIMENSION, factor * value_m, number, unit))
    assert most_likely(votes).resolution_m == pytest.approx(RESOLUTION, rel=1e-3)


def test_doors_make_fewer_texts_enough_where_they_agree():
    scale = math.log(RESOLUTION)
    two = [replace(vote, spread=0.004) for vote in cast([scale, scale + 0.003])]
    assert most_likely(two) is None
    assert most_likely(two, Prior(scale + 0.1, 0.12)) is not None
    assert most_likely(two, Prior(scale + 1.0, 0.12)) is None
