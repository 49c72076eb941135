# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The moving picture of a run: its pictures, and the way of the submap onto the floorplan."""

from dataclasses import replace

import numpy as np
from PIL import Image
import pytest

from fpnet.report.film import on_the_way, write_film
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import Affine2D, Similarity2D


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
