# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The moving picture of a run: its pictures, and the way of the submap onto the floorplan."""

from dataclasses import replace

import numpy as np
from PIL import Image
import pytest

from fpnet.report.film import on_the_way, write_film
from fpnet.report.sheets import Box, PictureSheet, fitted
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2, Affine2D, Similarity2D

BOX = Box(10, 20, 200, 100)


def test_a_film_shows_all_ticks_and_the_way_to_the_first_claim(made_up_run, tmp_path):
    path = tmp_path / 'new' / 'run.gif'
    write_film(path, made_up_run)
    with Image.open(path) as film:
        assert film.n_frames > 12, 'two ticks with a submap, and the way between'
        first = np.asarray(film.convert('RGB')).astype(int)
        film.seek(film.n_frames - 1)
        last = np.asarray(film.convert('RGB')).astype(int)
        assert film.info['loop'] == 0
    assert (np.abs(last - first).sum(axis=2) > 60).mean() > 0.002
    assert (first[0, 0] == 255).all()


def test_a_run_without_a_submap_has_no_film(made_up_run, tmp_path):
    with pytest.raises(FpnetError, match='no submap'):
        write_film(tmp_path / 'run.gif', replace(made_up_run, outputs=()))


def test_the_way_begins_and_ends_where_it_should_and_keeps_its_shape():
    flip = Affine2D(np.diag([10.0, -10.0]), np.array([300.0, 200.0]))
    end = flip @ Similarity2D.from_scale_yaw(1.5, np.deg2rad(130.0), (4.0, -3.0))
    assert on_the_way(flip, end, 0.0).matrix == pytest.approx(flip.matrix)
    assert on_the_way(flip, end, 1.0).matrix == pytest.approx(end.matrix)
    half = on_the_way(flip, end, 0.5)
    longest, shortest = np.linalg.svd(half.linear, compute_uv=False)
    assert longest == pytest.approx(shortest)
    assert half.translation == pytest.approx(0.5 * (flip.translation + end.translation))
    assert half.is_mirrored


def test_everything_is_shown_in_its_box_upright():
    xy = np.array([[1.0, 1.0], [5.0, 2.0]])
    A = fitted(xy, BOX)
    low, high = A.apply(xy)
    assert low[0] < high[0]
    assert low[1] > high[1], 'y of the frame points up'
    assert (A.apply(xy).mean(axis=0)) == pytest.approx((110, 70))
    turned = fitted(xy, BOX, SE2.from_xy_yaw(0.0, 0.0, np.deg2rad(90.0)))
    right = turned.linear @ np.array([0.0, 1.0])
    assert right[0] > 0
    assert right[1] == pytest.approx(0.0, abs=1e-9)


def test_an_arrow_points_ahead():
    sheet = PictureSheet.blank((100, 100))
    sheet.arrow(np.array([50.0, 50.0]), np.array([0.0, -1.0]), (0, 0, 0))
    rows, columns = np.nonzero(np.asarray(sheet.image()).sum(axis=2) < 200)
    assert columns.mean() == pytest.approx(49.5, abs=0.6)
    narrow, wide = np.ptp(columns[rows == rows.min() + 1]), np.ptp(columns[rows == rows.max() - 2])
    assert narrow < wide, 'its tip is up'
