# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Texts of whole drawings: areas in rooms of vector files, and pictures that are read."""

from dataclasses import replace

import numpy as np
from PIL import Image, ImageDraw, ImageFont
import pytest

from fpnet_core.drawings import ocr
from fpnet_core.drawings.annotations import annotated_scale
from fpnet_core.drawings.opening import open_drawing
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.room_texts import printed_of_rooms
from fpnet_core.drawings.types import Drawing, DrawingScale, Label, ReadOptions, ScaleSource
from fpnet_core.drawings.wording import said_of

needs_ocr = pytest.mark.skipif(
    not ocr.is_installed(), reason="texts are read by the extra ocr: pip install 'fpnet_ros[ocr]'"
)
WALL_M, DOOR_M, DEPTH_M, CORRIDOR_M = 0.2, 0.9, 4.4, 1.9
WIDTHS_M = ((2.6, 5.1, 3.4, 6.3, 4.2), (4.8, 3.0, 5.9, 3.7, 4.2))


def storey():
    """Return walls (left, low, right, high) [m] and free rooms on both sides of a corridor."""
    length = sum(WIDTHS_M[0]) + 6 * WALL_M
    high = 2 * DEPTH_M + CORRIDOR_M + 4 * WALL_M
    walls = [(0, 0, length, WALL_M), (0, high - WALL_M, length, high),
             (0, 0, WALL_M, high), (length - WALL_M, 0, length, high)]  # fmt: skip
    rooms = []
    for side, widths in enumerate(WIDTHS_M):
        low = WALL_M if side == 0 else high - WALL_M - DEPTH_M
        inner = WALL_M + DEPTH_M if side == 0 else low - WALL_M
        x = WALL_M
        for width in widths:
            door = x + width / 2 - DOOR_M / 2
            walls += [(x - WALL_M, inner, door, inner + WALL_M),
                      (door + DOOR_M, inner, x + width + WALL_M, inner + WALL_M),
                      (x + width, low, x + width + WALL_M, low + DEPTH_M)]  # fmt: skip
            rooms.append((x, low, x + width, low + DEPTH_M))
            x += width + WALL_M
    return walls, rooms, (length, high)


def square_metres(left, low, right, high):
    return f'{(right - left) * (high - low):.1f} m2'.replace('.', ',')


def in_feet(left, low, right, high):
    inches = (round((right - left) / 0.0254), round((high - low) / 0.0254))
    return ' x '.join(f'{each // 12}\'-{each % 12}"' for each in inches)


def write_svg(path, text_of, per_m):
    walls, rooms, (length, high) = storey()
    place = lambda x, y: ((x + 2.0) * per_m, (high + 2.0 - y) * per_m)  # noqa: E731
    parts = []
    for left, low, right, top in walls:
        x, y = place(left, top)
        size = f'width="{(right - left) * per_m:.3f}" height="{(top - low) * per_m:.3f}"'
        parts.append(f'<rect x="{x:.3f}" y="{y:.3f}" {size}/>')
    for number, room in enumerate(rooms):
        x, y = place((room[0] + room[2]) / 2, (room[1] + room[3]) / 2)
        style = f'font-size="{0.28 * per_m}" text-anchor="middle"'
        parts.append(f'<text x="{x}" y="{y}" {style}>2.{number:03d}</text>')
        text = text_of(*room).replace('"', '&quot;')
        parts.append(f'<text x="{x}" y="{y + 0.5 * per_m}" {style}>{text}</text>')
    box = f'0 0 {(length + 4.0) * per_m} {(high + 4.0) * per_m}'
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}">{"".join(parts)}</svg>'
    )
    return per_m


def write_pdf(path, text_of, ratio):
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    walls, rooms, (length, high) = storey()
    per_m = 1.0 / ratio / 0.0254
    size = np.array([length + 4.0, high + 4.0]) * per_m
    figure = Figure(size)
    place = lambda x, y: np.array([x + 2.0, y + 2.0]) * per_m / size  # noqa: E731
    for left, low, right, top in walls:
        corner, extent = place(left, low), np.array([right - left, top - low]) * per_m / size
        figure.add_artist(Rectangle(corner, *extent, color='black', linewidth=0))
    for number, room in enumerate(rooms):
        x, y = (room[0] + room[2]) / 2, (room[1] + room[3]) / 2
        for text, off in ((f'2.{number:03d}', 0.3), (text_of(*room), -0.3)):
            figure.text(*place(x, y + off), text, fontsize=0.28 * per_m * 72, ha='center')
    figure.savefig(path)
    return per_m * 72.0


def write_dxf(path, text_of, per_m):
    import ezdxf

    walls, rooms, _ = storey()
    document = ezdxf.new('R2010')
    document.header['$INSUNITS'] = 0
    space = document.modelspace()
    for left, low, right, top in walls:
        ring = np.array([(left, low), (right, low), (right, top), (left, top)]) * per_m
        space.add_lwpolyline(ring, close=True)
    for number, room in enumerate(rooms):
        x, y = (room[0] + room[2]) / 2 * per_m, (room[1] + room[3]) / 2 * per_m
        style = {'height': 0.25 * per_m}
        space.add_text(f'2.{number:03d}', dxfattribs=style).set_placement((x - per_m, y))
        space.add_text(text_of(*room), dxfattribs=style).set_placement((x - per_m, y - per_m))
    document.saveas(path)
    return per_m


@pytest.mark.slow
@pytest.mark.parametrize(
    ('write', 'name', 'text_of', 'scale'),
    [
        (write_svg, 'a.svg', square_metres, 37.0),
        (write_svg, 'a.svg', in_feet, 21.0),
        (write_pdf, 'a.pdf', square_metres, 90.0),
        (write_dxf, 'a.dxf', square_metres, 7.3),
    ],
)
def test_texts_in_rooms_of_vector_files_tell_the_scale(tmp_path, write, name, text_of, scale):
    per_m = write(tmp_path / name, text_of, scale)
    reading = read_plan(tmp_path / name)
    true_m = 1.0 / per_m / np.sqrt(abs(np.linalg.det(reading.drawing.A_pixel_image[:, :2])))
    assert reading.scale.source is ScaleSource.ROOM_TEXTS, reading.scale
    assert reading.scale.low_m < true_m < reading.scale.high_m
    assert reading.scale.resolution_m == pytest.approx(true_m, rel=0.025)


PIXEL_M = 0.0137


def picture(texts, lengths_m=(3.5, 2.2, 4.1, 5.3), at=(100, 120), font_px=22):
    """Return a picture (H, W, 3) of arrows, each with a text above, and where the texts are."""
    image = Image.new('RGB', (700, 600), 'white')
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(font_px)
    labels = []
    for row, (text, length_m) in enumerate(zip(texts, lengths_m, strict=True)):
        x, y = at[0], at[1] + 110 * row
        end = x + length_m / PIXEL_M
        draw.line([(x, y), (end, y)], fill='black', width=2)
        for tip, inwards in ((x, 9), (end, -9)):
            draw.polygon([(tip, y), (tip + inwards, y - 3), (tip + inwards, y + 3)], fill='black')
        place = ((x + end) / 2, y - 20)
        draw.text(place, text, fill='black', font=font, anchor='mm')
        labels.append(Label(text, draw.textbbox(place, text, font=font, anchor='mm')))
    return np.array(image), tuple(labels)


def test_texts_are_read_only_where_they_may_tell_the_scale(monkeypatch, tmp_path):
    pixels, labels = picture(['3.5 m', '2.2 m', '4.1 m', '5.3 m'])
    Image.fromarray(pixels).save(tmp_path / 'a.png')
    monkeypatch.setattr(ocr, 'is_installed', lambda: True)
    monkeypatch.setattr(ocr, 'read_labels', lambda _: labels)
    assert open_drawing(tmp_path / 'a.png').labels == labels
    assert open_drawing(tmp_path / 'a.png', ReadOptions(resolution_m=0.05)).labels == ()
    length = ReadOptions(length=(0.0, 0.0, 100.0, 0.0, 2.0))
    assert open_drawing(tmp_path / 'a.png', length).labels == ()
    known = Drawing(pixels, 'a', 'png', scale=DrawingScale(1.0, 1.0, 1.0, ScaleSource.UNITS))
    assert ocr.with_texts(known, ReadOptions()) is known
    monkeypatch.setattr(ocr, 'is_installed', lambda: False)
    assert open_drawing(tmp_path / 'a.png').labels == ()


def test_a_note_names_the_extra_where_it_would_have_helped(monkeypatch, tmp_path):
    pixels, labels = picture(['3.5 m', '2.2 m', '4.1 m', '5.3 m'])
    Image.fromarray(pixels).save(tmp_path / 'a.png')
    (tmp_path / 'a.yaml').write_text(
        'image: a.png\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\n'
        'negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n'
    )
    stated = read_plan(tmp_path / 'a.yaml')
    guess = DrawingScale(0.05, 0.04, 0.06, ScaleSource.ESTIMATED)
    unread = replace(stated, drawing=Drawing(pixels, 'a.png', 'png'), scale=guess)
    monkeypatch.setattr(ocr, 'is_installed', lambda: False)
    assert ocr.NOT_READ in said_of(unread)
    assert ocr.NOT_READ not in said_of(stated)
    lettered = replace(unread, drawing=replace(unread.drawing, labels=labels))
    assert ocr.NOT_READ not in said_of(lettered)
    monkeypatch.setattr(ocr, 'is_installed', lambda: True)
    assert ocr.NOT_READ not in said_of(unread)


@needs_ocr
def test_a_picture_tells_its_scale_by_what_is_written_on_it(tmp_path):
    pixels, _ = picture(['3.5 m', '2.2 m', '4.1 m', '5.3 m'])
    Image.fromarray(pixels).save(tmp_path / 'a.png')
    scale = annotated_scale(open_drawing(tmp_path / 'a.png'))
    assert scale.resolution_m == pytest.approx(PIXEL_M, rel=0.006)


@needs_ocr
def test_names_on_a_picture_are_those_of_its_rooms():
    image = Image.new('RGB', (700, 300), 'white')
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(24)
    rooms = np.zeros((300, 700), np.int32)
    for number, lines in enumerate((('2.14', 'Office', '13.2 m2'), ('2.15', 'Kitchen'))):
        left = 20 + 340 * number
        draw.rectangle([left, 20, left + 320, 280], outline='black', width=5)
        rooms[25:275, left + 5 : left + 315] = number + 1
        for row, line in enumerate(lines):
            draw.text((left + 160, 80 + 50 * row), line, fill='black', font=font, anchor='mm')
    one, two = printed_of_rooms(ocr.read_labels(np.array(image)), rooms)
    assert (one.name, one.number, one.area_m2) == ('Office', '2.14', 13.2)
    assert (two.name, two.number, two.area_m2) == ('Kitchen', '2.15', None)


def test_arrows_on_a_picture_are_measured():
    pixels, labels = picture(['3.5 m', '2.2 m', '4.1 m', '5.3 m'])
    scale = annotated_scale(Drawing(pixels, 'a.png', 'png', labels=labels))
    assert scale.source is ScaleSource.DIMENSIONS
    assert scale.resolution_m == pytest.approx(PIXEL_M, rel=0.006)
    assert scale.low_m < PIXEL_M < scale.high_m
    wrong = picture(['3.5 m', '4.9 m', '1.7 m', '9.2 m'])
    assert annotated_scale(Drawing(wrong[0], 'a.png', 'png', labels=wrong[1])) is None
