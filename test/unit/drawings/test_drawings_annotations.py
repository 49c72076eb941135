# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The scale that a drawing states: dimensions, bars, 1:100; and what is no such statement."""

import math

import numpy as np
from plan_files import write_pdf
import pytest

from fpnet_core.drawings.annotations import annotated_scale
from fpnet_core.drawings.lengths import lengths
from fpnet_core.drawings.opening import open_drawing
from fpnet_core.drawings.types import Drawing, Label, ScaleSource, Strokes

RESOLUTION = 0.02
LENGTHS_M = (6.25, 3.4, 8.15, 2.05)


def drawn(lines, labels, paper_m=None, door_px=(), size=2000):
    ends = np.asarray(lines, float).reshape(-1, 2, 2)
    count = len(ends)
    strokes = Strokes(
        ends, np.ones(count), np.zeros((count, 3), np.uint8), np.arange(count),
        np.zeros(count, bool), np.zeros(count, int),
    )  # fmt: skip
    pixels = np.full((size, size, 3), 255, np.uint8)
    return Drawing(
        pixels, 'a', 'pdf', strokes, tuple(labels), paper_m=paper_m, door_px=tuple(door_px)
    )


def label(text, x, y, height=12.0, upright=False):
    half = 0.3 * height * len(text)
    across, along = (height / 2, half) if upright else (half, height / 2)
    return Label(text, (x - across, y - along, x + across, y + along))


def chain(texts, lengths_m=LENGTHS_M, x=100.0, y=300.0, upright=False):
    """Return a chain of dimensions: one line, ticks, extension lines, and texts above it."""
    lines, labels, at = [], [], x
    for text, length_m in zip(texts, lengths_m, strict=True):
        end = at + length_m / RESOLUTION
        lines += [((at, y - 30), (at, y + 8)), ((at - 4, y + 4), (at + 4, y - 4))]
        labels.append(label(text, (at + end) / 2, y - 10, upright=False))
        at = end
    lines += [((at, y - 30), (at, y + 8)), ((x, y), (at, y))]
    if upright:
        turn = lambda p: (p[1], 1900.0 - p[0])  # noqa: E731
        lines = [(turn(a), turn(b)) for a, b in lines]
        labels = [
            Label(k.text, (k.box[1], 1900.0 - k.box[2], k.box[3], 1900.0 - k.box[0]))
            for k in labels
        ]
    return lines, labels


@pytest.mark.parametrize(
    'texts',
    [
        ['6.25', '3.40', '8.15', '2.05'],
        ['6,25', '3,40', '8,15', '2,05'],
        ['6250', '3400', '8150', '2050'],
        ['6.25 m', '3.40 m', '8.15 m', '2.05 m'],
        ['625', '340', '815', '205'],
        ['6250 mm', '3.4m', '815 cm', '2.05'],
        ['20\'-6 1/16"', '11\'-1 7/8"', '26\'-8 7/8"', '6\'-8 11/16"'],
    ],
)
@pytest.mark.parametrize('upright', [False, True])
def test_dimensions_in_every_notation(texts, upright):
    scale = annotated_scale(drawn(*chain(texts, upright=upright)))
    assert scale is not None
    assert scale.source is ScaleSource.DIMENSIONS
    assert scale.resolution_m == pytest.approx(RESOLUTION, rel=0.004)
    assert scale.low_m < RESOLUTION < scale.high_m


def test_one_dimension_is_not_believed():
    lines, labels = chain(['6.25'], LENGTHS_M[:1])
    assert annotated_scale(drawn(lines, labels)) is None
    again, more = chain(['6.25', '6.25', '6.25'], (6.25,) * 3, y=600.0)
    assert annotated_scale(drawn(lines + again, labels + more)) is None


def test_doors_contradict_wrong_dimensions():
    lines, labels = chain(['62.5', '34.0', '81.5', '20.5'])  # ten times too long
    assert annotated_scale(drawn(lines, labels, door_px=[45.0] * 4)) is None
    right = chain(['6.25', '3.40', '8.15', '2.05'])
    assert annotated_scale(drawn(*right, door_px=[45.0] * 4)) is not None


def bar(texts=('0', '5', '10 m'), values=(0, 5, 10), pixel_m=RESOLUTION, updates=True):
    places = [200.0 + value / pixel_m for value in values]
    lines = [((places[0], 900), (places[-1], 900))]
    if updates:
        lines += [((x, 890), (x, 900)) for x in places]
    # The unit behind the last number pushes its middle to the right.
    labels = [
        label(text, x + 0.3 * 12 * (len(text) - len(text.split()[0])), 915)
        for text, x in zip(texts, places, strict=True)
    ]
    return lines, labels


def test_scale_bars():
    scale = annotated_scale(drawn(*bar()))
    assert scale is not None
    assert scale.source is ScaleSource.SCALE_BAR
    assert scale.resolution_m == pytest.approx(RESOLUTION, rel=0.003)
    feet = annotated_scale(drawn(*bar(('0', '10', '20', '30 ft'), (0, 10, 20, 30), 0.05)))
    assert feet.resolution_m == pytest.approx(0.05 * 0.3048, rel=0.003)


def test_a_bar_and_dimensions_that_contradict_say_nothing():
    lines, labels = chain(['6.25', '3.40', '8.15', '2.05'])
    more, numbers = bar(pixel_m=0.03)
    assert annotated_scale(drawn(lines + more, labels + numbers)) is None
    more, numbers = bar()
    assert annotated_scale(drawn(lines + more, labels + numbers)) is not None


def test_a_stated_ratio_needs_paper_and_doors():
    labels = [label('Scale 1:100', 500, 500)]
    line = [((0, 0), (1900, 0))]
    found = annotated_scale(drawn(line, labels, 2e-4, [45.0] * 3))
    assert found.source is ScaleSource.PAPER
    assert found.resolution_m == pytest.approx(0.02, rel=1e-3)
    assert annotated_scale(drawn(line, labels, None, [45.0] * 3)) is None
    assert annotated_scale(drawn(line, labels, 2e-4)) is None
    # Printed on paper of half the size: doors would be 2.2 m wide.
    assert annotated_scale(drawn(line, labels, 2e-4, [110.0] * 3)) is None
    two = [*labels, label('1:50', 900, 500)]
    assert annotated_scale(drawn(line, two, 2e-4, [45.0] * 3)) is None


def test_on_a_page_of_a_pdf(tmp_path):
    lines, texts, x = [], [], 0.3
    for length in (5.7, 3.9):
        lines += [((x, -0.8), (x + length, -0.8)), ((x, -1.0), (x, -0.6))]
        texts.append((x + length / 2, -0.7, f'{length:.2f}'))
        x += length + 0.2
    for length, y in ((2.05, -1.2), (10.4, -1.5)):
        lines.append(((0.0, y), (length, y)))
        texts.append((length / 2, y + 0.1, f'{length:.2f}'))
    drawing = open_drawing(write_pdf(tmp_path / 'a.pdf', 50.0, texts, lines=lines))
    scale = annotated_scale(drawing)
    pixels_per_point = math.sqrt(np.linalg.det(drawing.A_pixel_image[:, :2]))
    true_m = 50.0 * 0.0254 / 72.0 / pixels_per_point
    assert scale.resolution_m == pytest.approx(true_m, rel=0.004)


def test_dimensions_that_do_not_fit_their_lines_say_nothing():
    assert annotated_scale(drawn(*chain(['6.25', '5.10', '2.90', '7.77']))) is None


def test_numbers_of_rooms_are_no_dimensions():
    rng = np.random.default_rng(5)
    lines, labels = [], []
    for k in range(40):
        x, y = rng.uniform(100, 1900, 2)
        w, h = rng.uniform(80, 300, 2)
        a, b, c, d = (x - w, y - h), (x + w, y - h), (x + w, y + h), (x - w, y + h)
        lines += [(a, b), (b, c), (c, d), (d, a)]
        labels += [label(f'{k // 10 + 1}.{k:03d}', x, y), label(f'{w * h / 999:.1f}', x, y + 15)]
    assert annotated_scale(drawn(lines, labels)) is None


def test_rows_of_numbers_are_no_scale_bars():
    assert annotated_scale(drawn(*bar(updates=False))) is None
    assert annotated_scale(drawn(*bar(('0', '5', '10')))) is None  # of what?
    lines, labels = bar(('0', '5', '10 m'), (0, 3, 10))
    assert annotated_scale(drawn(lines, labels)) is None


@pytest.mark.parametrize('text', ['14.0 m2', '1:100', '15.07.2016', 'Office', 'A-3', '', '12 kg'])
def test_what_is_no_length(text):
    assert list(lengths(text)) == []
