# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What counts as read right, marked and sure, with readers made to order."""

from dataclasses import replace
import hashlib
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.types import Drawing, DrawingScale, Reading, ScaleSource
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import Similarity2D
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap
from fpnet_lab.evaluation import drawings_real
from fpnet_lab.evaluation.drawings import SheetResult, kind_figures, read_sheet, scale_figures
from fpnet_lab.evaluation.real_drawings import SPLITS, bench_drawing, find_drawing, read_truth
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.sheets import draw_sheet

CONFIG = SegmentationConfig()
CELL_M = 0.05
GOOD = SheetResult('clean', 'a', f1=0.9, ratio=1.02, low=0.9, high=1.2)


def reading_of(grid, H_plan_image, scale, doubts=()):
    drawing = Drawing(np.zeros((1, 1, 3), np.uint8), 'made to order', 'png')
    return Reading(grid, scale, H_plan_image, 'by the truth', drawing, doubts=doubts)


def knowing_reader(stretch=1.0, source=ScaleSource.LENGTH, doubts=(), storey=0, sheets=None):
    """A reader that draws the truth, all of it ``stretch`` times too large and turned."""

    def read(path):
        kind, seed = path.stem.split('-')
        sheet = sheets[path.stem] if sheets else draw_sheet(int(seed), kind)
        A = Similarity2D.from_scale_yaw(stretch, 0.3, (4.0, -7.0))
        grid = render_plan(sheet.storeys[storey].plan, CELL_M, T_plan_building=A)
        scale = DrawingScale(CELL_M, 0.95 * CELL_M, 1.05 * CELL_M, source)
        H_plan_image = A.matrix @ np.linalg.inv(sheet.H_image_building(storey))
        return reading_of(grid, H_plan_image, scale, doubts)

    return read


@pytest.mark.parametrize('kind', ['clean', 'phone'])
def test_a_reader_that_knows_the_truth_is_right(tmp_path, kind):
    result, rooms = read_sheet(knowing_reader(), draw_sheet(3, kind), tmp_path, CONFIG)
    assert result.f1 == pytest.approx(rooms.f1)
    assert result.is_right
    assert not result.is_marked
    assert result.ratio == pytest.approx(1.0, abs=0.02)
    assert result.is_held
    assert list(tmp_path.iterdir()) == []


def test_a_wrong_scale_is_right_only_if_nobody_calls_it_sure(tmp_path):
    sheet = draw_sheet(3, 'clean')
    sure, _ = read_sheet(knowing_reader(1.3), sheet, tmp_path, CONFIG)
    assert sure.ratio == pytest.approx(1.3, abs=0.02)
    assert sure.is_sure
    assert not sure.is_close
    assert not sure.is_held
    assert not sure.is_right
    unsure = replace(sure, is_known=False, low=0.6, high=1.1, f1=0.9)
    assert unsure.is_right
    assert unsure.is_held


def test_shares_of_right_and_marked_sheets():
    bad = replace(GOOD, name='b', f1=0.2)
    results = [GOOD, replace(GOOD, doubts=('no doors',)), bad, replace(bad, doubts=('one room',))]
    results.append(replace(bad, refusal='not a plan', ratio=None))
    figures = kind_figures(results)
    assert figures['right'] == pytest.approx(2 / 5)
    assert figures['wrong_marked'] == pytest.approx(2 / 3)
    assert figures['good_marked'] == pytest.approx(1 / 2)
    assert [wrong['name'] for wrong in figures['wrong']] == ['b', 'b', 'b']
    assert kind_figures([])['right'] is None


def test_figures_of_scale_leave_out_what_was_doubted():
    far = replace(GOOD, ratio=1.25, low=0.95, high=1.05)
    doubted = replace(far, doubts=('too wide doors',))
    stated = replace(GOOD, ratio=1.0, low=1.0, high=1.0, is_known=True)
    figures = scale_figures([GOOD, far, doubted, stated])
    assert figures['sheets'] == 3
    assert figures['within_10'] == pytest.approx(2 / 3)
    assert figures['interval_holds'] == pytest.approx(1 / 2)
    assert figures['sure'] == 2
    assert figures['sure_and_wrong'] == pytest.approx(1 / 2)


@pytest.fixture
def real_plan(tmp_path, monkeypatch):
    """A folder with one labelled plan of two rooms at 0.05 m per pixel."""
    image = np.zeros((130, 220), np.uint8)
    image[10:120, 10:110] = image[10:120, 116:210] = 254
    labels = np.zeros(image.shape, np.uint16)
    labels[10:120, 10:110], labels[10:120, 116:210] = 1, 2
    image[50:68, 110:116] = 254  # the door
    for folder, pixels in (('floorplan', image), ('room_labels', labels)):
        (tmp_path / 'bormann' / folder).mkdir(parents=True)
        cv2.imwrite(str(tmp_path / 'bormann' / folder / 'two.png'), pixels)
    monkeypatch.setattr(drawings_real, 'plan_names', lambda half: ('two',))
    return tmp_path


def test_real_plans_are_compared_with_black_walls_and_labels(real_plan):
    binarization = []

    def read(path):
        pixels = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        binarization.append(int(pixels.min()))
        # A reader for which whatever is darker than 120 is a wall, and that takes 0.06 m.
        cells = np.where(pixels[::-1] < 120, OCCUPIED, FREE)
        scale = DrawingScale(0.06, 0.04, 0.07, ScaleSource.ESTIMATED)
        rows = len(pixels)
        H_plan_image = np.array([[0.06, 0, 0.03], [0, -0.06, (rows - 0.5) * 0.06], [0, 0, 1]])
        return reading_of(GridMap(cells, 0.06), H_plan_image, scale)

    report = drawings_real.bench_plans(read, real_plan, real_plan, 'tune', CONFIG)
    assert binarization == [0, 30, 60, 100, 140, 1]
    shares = {tone: figures['as_black'] for tone, figures in report['tones'].items()}
    walls = {tone: figures['walls_as_black'] for tone, figures in report['tones'].items()}
    assert walls['100'] == 1.0
    assert walls['140'] == 0.0
    assert shares == {'0': 1, '30': 1, '60': 1, '100': 1, '140': 0, 'inverted': 0}
    assert report['tones']['0']['f1_mean'] == pytest.approx(1.0)
    assert report['scale'] | {'median_width': 0} == {
        'sheets': 1, 'within_10': 0.0, 'interval_holds': 1.0, 'sure': 0, 'sure_and_wrong': None,
        'median_width': 0,
    }  # fmt: skip


TRUTHS = Path(__file__).resolve().parents[3] / 'benchmarks' / 'real_drawings'
REAL_CELL_M, PIXEL_M = 0.05, 0.02
ROOMS = [(1.0, 1.0, 5.0, 4.0), (5.2, 1.0, 9.2, 4.0), (1.0, 4.2, 9.2, 8.2)]  # metres, y up
DOORS = [(5.1, 2.0, 5.1, 2.9), (2.5, 4.1, 3.4, 4.1), (7.0, 4.1, 7.9, 4.1)]
HEIGHT_M = 10.0


def to_pixels(xy):
    return (np.array(xy, float) * [1, -1] + [0, HEIGHT_M]) / PIXEL_M


def values():
    rings = [[(x0, y0), (x1, y0), (x1, y1), (x0, y1)] for x0, y0, x1, y1 in ROOMS]
    return {
        'file': 'storey.png',
        'sha256': hashlib.sha256(b'pixels').hexdigest(),
        'split': 'tune',
        'kind': 'made to order',
        'source': {'repository': 'a/b', 'commit': 'c0ffee', 'path': 'p', 'licence': 'MIT'},
        'metres_per_unit': PIXEL_M,
        'rooms': [to_pixels(ring).tolist() for ring in rings],
        'doors': [to_pixels(np.reshape(door, (2, 2))).tolist() for door in DOORS],
    }


def truth_of(tmp_path, **changes):
    path = tmp_path / 'storey.json'
    path.write_text(json.dumps(values() | changes))
    return read_truth(path)


def reader(stretch=1.0, doubts=()):
    """A reader that draws the truth, with its metres ``stretch`` times too long."""

    def fill(cells, box, value):
        x0, y0, x1, y1 = np.round(np.array(box) / REAL_CELL_M).astype(int)
        cells[y0:y1, x0:x1] = value

    def read(_path, _options):
        cells = np.full((200, 220), UNKNOWN, np.int8)
        fill(cells, (0.8, 0.8, 9.4, 8.4), OCCUPIED)
        for room in ROOMS:
            fill(cells, room, FREE)
        for x0, y0, x1, y1 in DOORS:
            thick = (0.1, 0.0) if x0 == x1 else (0.0, 0.1)
            fill(cells, (x0 - thick[0], y0 - thick[1], x1 + thick[0], y1 + thick[1]), FREE)
        grid = GridMap(cells, REAL_CELL_M * stretch)
        H = np.diag([stretch, stretch, 1.0]) @ np.array(
            [[PIXEL_M, 0.0, 0.0], [0.0, -PIXEL_M, HEIGHT_M], [0.0, 0.0, 1.0]]
        )
        metres = REAL_CELL_M * stretch
        scale = DrawingScale(metres, 0.9 * metres, 1.1 * metres, ScaleSource.LENGTH)
        drawing = Drawing(np.zeros((1, 1, 3), np.uint8), 'made to order', 'png')
        return Reading(grid, scale, H, 'by the truth', drawing, doubts=doubts)

    return read


def test_a_reader_that_knows_a_real_drawing_is_right(tmp_path):
    row, sheet, rooms, _ = bench_drawing(reader(), truth_of(tmp_path), tmp_path, CONFIG)
    assert (row['f1'], row['precision'], row['recall']) == (1.0, 1.0, 1.0)
    assert (row['door_precision'], row['door_recall']) == (1.0, 1.0)
    assert row['scale_ratio'] == pytest.approx(1.0)
    assert row['interval_holds'] is True
    assert row['verdict'] == 'fit'
    assert row['silent'] is False
    assert sheet.f1 == rooms.f1 == 1.0


def test_a_scale_outside_of_its_interval_is_silent_unless_doubted(tmp_path):
    truth = truth_of(tmp_path)
    row = bench_drawing(reader(1.3), truth, tmp_path, CONFIG)[0]
    assert row['scale_ratio'] == pytest.approx(1.3)
    assert row['interval_holds'] is False
    assert row['silent'] is True
    doubted = bench_drawing(reader(1.3, ('thin walls',)), truth, tmp_path, CONFIG)[0]
    assert doubted['verdict'] == 'doubtful'
    assert doubted['silent'] is False
    unknown = truth_of(tmp_path, metres_per_unit=None)
    row = bench_drawing(reader(1.3), unknown, tmp_path, CONFIG)[0]
    assert row['interval_holds'] is None
    assert row['scale_ratio'] is None
    assert row['door_recall'] == 1.0


@pytest.mark.parametrize(
    ('changes', 'said'),
    [
        ({'split': 'test'}, "split 'test'"),
        ({'rooms': []}, 'at least one'),
        ({'rooms': [[[0, 0], [1, 1]]]}, 'three corners'),
        ({'metres_per_unit': 0}, 'metres_per_unit'),
        ({'source': {}}, "there is no 'repository'"),
        ({'options': {'level': 2}}, 'level'),
    ],
)
def test_a_truth_that_is_none_says_why(tmp_path, changes, said):
    with pytest.raises(FpnetError, match=said):
        truth_of(tmp_path, **changes)


def test_a_drawing_is_found_by_name_and_known_by_its_bytes(tmp_path):
    truth = truth_of(tmp_path)
    assert find_drawing(truth, [tmp_path]) is None
    (tmp_path / 'drawings').mkdir()
    path = tmp_path / 'drawings' / truth.file
    path.write_bytes(b'pixels')
    assert find_drawing(truth, [tmp_path]) == path
    path.write_bytes(b'others')
    with pytest.raises(FpnetError, match='SHA-256'):
        find_drawing(truth, [tmp_path])


def test_committed_truths_are_sound():
    truths = [read_truth(path) for path in sorted(TRUTHS.glob('*.json'))]
    of_split = {split: [each for each in truths if each.split == split] for split in SPLITS}
    repositories = [{each.source['repository'] for each in of_split[split]} for split in SPLITS]
    assert min(map(len, of_split.values())) >= 10
    assert repositories[0].isdisjoint(repositories[1]), 'a building is in one split only'
    for truth in truths:
        assert len(truth.sha256) == 64
        assert all(shapely.Polygon(ring).area > 0 for ring in truth.rooms), truth.name
        if truth.doors is not None:
            assert (truth.doors[:, 0] != truth.doors[:, 1]).any(axis=1).all(), truth.name
