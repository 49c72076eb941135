# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Truths of real drawings, and how readings are held against them."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
import shapely

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.types import Drawing, DrawingScale, Reading, ScaleSource
from fpnet_core.errors import FpnetError
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap
from fpnet_lab.evaluation.real_drawings import (
    SPLITS,
    bench_drawing,
    find_drawing,
    read_truth,
)

TRUTHS = Path(__file__).resolve().parents[3] / 'benchmarks' / 'real_drawings'
CONFIG = SegmentationConfig()
CELL_M, PIXEL_M = 0.05, 0.02
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
        x0, y0, x1, y1 = np.round(np.array(box) / CELL_M).astype(int)
        cells[y0:y1, x0:x1] = value

    def read(_path, _options):
        cells = np.full((200, 220), UNKNOWN, np.int8)
        fill(cells, (0.8, 0.8, 9.4, 8.4), OCCUPIED)
        for room in ROOMS:
            fill(cells, room, FREE)
        for x0, y0, x1, y1 in DOORS:
            thick = (0.1, 0.0) if x0 == x1 else (0.0, 0.1)
            fill(cells, (x0 - thick[0], y0 - thick[1], x1 + thick[0], y1 + thick[1]), FREE)
        grid = GridMap(cells, CELL_M * stretch)
        H = np.diag([stretch, stretch, 1.0]) @ np.array(
            [[PIXEL_M, 0.0, 0.0], [0.0, -PIXEL_M, HEIGHT_M], [0.0, 0.0, 1.0]]
        )
        metres = CELL_M * stretch
        scale = DrawingScale(metres, 0.9 * metres, 1.1 * metres, ScaleSource.LENGTH)
        drawing = Drawing(np.zeros((1, 1, 3), np.uint8), 'made to order', 'png')
        return Reading(grid, scale, H, 'by the truth', drawing, doubts=doubts)

    return read


def test_a_reader_that_knows_the_truth_is_right(tmp_path):
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
