# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What counts as read right, marked and sure, with readers made to order."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.types import Drawing, DrawingScale, Reading, ScaleSource
from fpnet_core.geometry import Similarity2D
from fpnet_core.types import FREE, OCCUPIED, GridMap
from fpnet_lab.evaluation import drawings_real
from fpnet_lab.evaluation.drawings import (
    SheetResult,
    kind_figures,
    read_sheet,
    scale_figures,
)
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
