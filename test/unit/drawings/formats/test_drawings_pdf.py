# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""PDF: the page, its lines and texts, scans, what is refused."""

import numpy as np
from plan_files import (
    DASHED,
    IN_ROOMS,
    LEAF,
    ON_ARC,
    ON_WALLS,
    TEXT,
    levels,
    pdf_points,
    write_pdf,
)
import pytest

from fpnet_core.drawings.formats.page_texts import merge_labels
from fpnet_core.drawings.formats.pdf import POINT_M
from fpnet_core.drawings.opening import open_drawing
from fpnet_core.drawings.types import Label, ReadOptions
from fpnet_core.errors import MapFormatError


def page(content: bytes, media='0 0 500 400', more=b'', extra=b'') -> bytes:
    """Return a PDF of one page."""
    objects = [
        b'<</Type/Catalog/Pages 2 0 R>>',
        b'<</Type/Pages/Kids[3 0 R]/Count 1>>',
        b'<</Type/Page/Parent 2 0 R/MediaBox['
        + media.encode()
        + b']/Contents 4 0 R'
        + more
        + b'>>',
        b'<</Length %d%s>>stream\n' % (len(content), extra) + content + b'\nendstream',
    ]
    out, offsets = b'%PDF-1.4\n', []
    for number, body in enumerate(objects, 1):
        offsets.append(len(out))
        out += b'%d 0 obj' % number + body + b'endobj\n'
    table = b''.join(b'%010d 00000 n \n' % offset for offset in offsets)
    size, start = len(objects) + 1, len(out)
    return out + (
        b'xref\n0 %d\n0000000000 65535 f \n' % size + table
        + b'trailer<</Size %d/Root 1 0 R>>\nstartxref\n%d\n%%%%EOF' % (size, start)
    )  # fmt: skip


@pytest.mark.usefixtures('own_process')
def test_walls_are_drawn_where_they_are_and_nothing_else(tmp_path):
    drawing = open_drawing(write_pdf(tmp_path / 'a.pdf'))
    assert (levels(drawing, pdf_points(ON_WALLS)) == 0).all()
    white = pdf_points([*IN_ROOMS, LEAF, ON_ARC, TEXT, DASHED[0]])
    assert (levels(drawing, white) == 255).all()
    assert [label.text for label in drawing.labels] == ['Office']
    assert len(drawing.door_px) == 3


def test_size_on_paper(tmp_path):
    drawing = open_drawing(write_pdf(tmp_path / 'a.pdf'))
    pixels_per_point = np.sqrt(np.linalg.det(drawing.A_pixel_image[:, :2]))
    assert drawing.paper_m * pixels_per_point == pytest.approx(POINT_M)
    # At 1:50 a door of 0.9 m has 18 mm on paper.
    assert np.median(drawing.door_px) * drawing.paper_m == pytest.approx(0.018, rel=0.01)


def test_the_page_with_the_plan_is_chosen(tmp_path):
    path = write_pdf(tmp_path / 'a.pdf', pages=3)
    drawing = open_drawing(path)
    assert 'page 3 of 3 looks most like a floorplan' in drawing.notes
    assert (levels(drawing, pdf_points(ON_WALLS)) == 0).all()
    with pytest.raises(MapFormatError, match='no lines'):
        open_drawing(path, ReadOptions(page=2))
    with pytest.raises(MapFormatError, match='3 pages; there is no page 4'):
        open_drawing(path, ReadOptions(page=4))


@pytest.mark.parametrize(('turn', 'place'), [
    (0, (100, 300)), (90, (100, 100)), (180, (400, 100)), (270, (300, 400)),
])  # fmt: skip
def test_turned_pages_are_upright(tmp_path, turn, place):
    # A bar at (100, 100) from the lower left of a page of 500 x 400 points; y down as shown.
    content = b'90 90 20 20 re f 200 200 m 450 350 l 450 300 l S'
    (tmp_path / 'a.pdf').write_bytes(page(content, more=b'/Rotate %d' % turn))
    assert levels(open_drawing(tmp_path / 'a.pdf'), [place]) == 0


def test_names_of_layers(tmp_path):
    content = (
        b'/OC /L1 BDC 10 10 m 400 10 l 400 300 l 10 300 l h S EMC '
        b'/OC /L2 BDC 100 100 50 50 re f EMC'
    )
    layers = b'<</Properties<</L1<</Type/OCG/Name(A-WALL)>>/L2<</Type/OCG/Name(A-FURN)>>>>>>'
    (tmp_path / 'a.pdf').write_bytes(page(content, more=b'/Resources' + layers))
    drawing = open_drawing(tmp_path / 'a.pdf')
    assert drawing.strokes.layers == ('A-WALL', 'A-FURN')
    assert levels(drawing, [(200, 390), (125, 275)]).tolist() == [0.0, 255.0]


def test_forms_and_clipping(tmp_path):
    content = (
        b'q 100 100 m 200 100 l 100 200 l h W n 0 0 500 400 re f Q '
        b'q 1 0 0 1 250 250 cm 2 0 0 2 0 0 cm 0 0 10 10 re f Q 5 w 20 20 m 480 20 l S'
    )
    (tmp_path / 'a.pdf').write_bytes(page(content))
    found = levels(
        open_drawing(tmp_path / 'a.pdf'), [(120, 280), (180, 220), (260, 140), (240, 380)]
    )
    assert found.tolist() == [0.0, 255.0, 0.0, 0.0]


def test_a_scan_is_shown_as_it_is(tmp_path):
    from matplotlib.figure import Figure

    figure = Figure((8.0, 6.0))
    picture = np.kron([[0, 255], [255, 0]], np.ones((40, 40)))
    picture[:, -1] = np.linspace(0, 255, 80)  # of two colours older Matplotlib garbles
    figure.add_axes((0, 0, 1, 1)).imshow(picture, 'gray')
    figure.axes[0].axis('off')
    figure.savefig(tmp_path / 'a.pdf')
    drawing = open_drawing(tmp_path / 'a.pdf')
    assert 'the page is a scan' in drawing.notes
    # The square picture is in the middle of the page, 432 points wide.
    points = [(150, 100), (400, 100), (150, 300), (400, 300)]
    assert levels(drawing, points).round().tolist() == [0, 255, 255, 0]


ENCRYPTED = (
    b'%PDF-1.4\n1 0 obj<</Type/Catalog/Pages 2 0 R>>endobj\n'
    b'2 0 obj<</Type/Pages/Kids[]/Count 0>>endobj\n'
    b'4 0 obj<</Filter/Standard/V 1/R 2/O('
    + b'\1' * 32
    + b')/U('
    + b'\2' * 32
    + b')/P -4>>endobj\n'
    b'trailer<</Root 1 0 R/Encrypt 4 0 R/ID[(a)(a)]>>\n%%EOF'
)


@pytest.mark.usefixtures('own_process')
@pytest.mark.parametrize(('data', 'message'), [
    (ENCRYPTED, 'encrypted'),
    (b'%PDF-1.7\n' + bytes(range(256)) * 9, 'damaged PDF'),
    (page(b'0 0 m 9 9 l S')[:150], 'damaged PDF'),
    (page(b''), 'no lines'),
])  # fmt: skip
def test_bad_files_are_refused_in_a_line(tmp_path, data, message):
    (tmp_path / 'a.pdf').write_bytes(data)
    with pytest.raises(MapFormatError, match=rf'\Aa\.pdf [^\n]*{message}[^\n]*\Z'):
        open_drawing(tmp_path / 'a.pdf')


def test_a_huge_page_costs_no_more_than_a_small_one(tmp_path):
    (tmp_path / 'a.pdf').write_bytes(page(b'0 0 m 90000 0 l 90000 90000 l S', '0 0 200000 200000'))
    assert max(open_drawing(tmp_path / 'a.pdf').pixels.shape) < 4000


def test_letters_and_words_of_a_line_are_joined():
    letters = [Label(c, (10.0 + 6 * k, 0.0, 15.0 + 6 * k, 8.0)) for k, c in enumerate('6.25')]
    word = Label('m', (36.5, 0.0, 42.0, 8.0))
    far = Label('A', (80.0, 0.0, 86.0, 8.0))
    upwards = [Label(c, (100.0, 50.0 - 6 * k, 108.0, 55.0 - 6 * k)) for k, c in enumerate('12')]
    found = merge_labels([*letters, word, far, *upwards])
    assert sorted(label.text for label in found) == ['12', '6.25 m', 'A']


def test_numbers_of_a_scale_bar_stay_apart():
    words = [Label('Office', (0.0, 50.0 * k, 40.0, 50.0 * k + 8.0)) for k in range(1, 6)]
    numbers = [Label(c, (10.0 + 6 * k, 0.0, 15.0 + 6 * k, 8.0)) for k, c in enumerate('012')]
    found = merge_labels([*words, *numbers])
    assert sorted(label.text for label in found)[:3] == ['0', '1', '2']
