# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pixels, metres, rays and lines in a frame that is turned by no quarter."""

import cv2
import numpy as np
import pytest

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.raster.blocks import block_middles
from fpnet_core.raster.pixels import corners_xy, cut_from, map_points, shrinking, xy_to_rc
from fpnet_core.raster.rays import cells_at, draw_line, marked, nearest_cell, run_lengths
from fpnet_core.raster.warping import warped_grid
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap

POSE = SE2.from_xy_yaw(3.0, -2.0, 0.4)


def turned_grid(shape=(30, 40), resolution=0.1):
    return GridMap(np.zeros(shape, dtype=np.int8), resolution, POSE)


@pytest.mark.parametrize('step', [1, 2, 3, 4])
def test_a_coarser_raster_is_found_from_metres(step):
    grid = turned_grid()
    rows, cols = np.indices(grid.shape)
    A = xy_to_rc(grid, step)
    xy = grid.rc_to_xy(
        np.stack([block_middles(rows, step), block_middles(cols, step)], axis=-1)
    ).reshape(-1, 2)
    found = (xy @ A[:, :2].T + A[:, 2]).reshape(*block_middles(rows, step).shape, 2)
    assert nearest_cell(A, *xy[-1]) == (found.shape[0] - 1, found.shape[1] - 1)
    np.testing.assert_allclose(found, np.moveaxis(np.indices(found.shape[:2]), 0, 2), atol=1e-9)


def test_corners_are_the_outer_ones():
    corners = corners_xy(turned_grid((30, 40), 0.1))
    np.testing.assert_allclose(corners[0], POSE.translation, atol=1e-12)
    sides = np.linalg.norm(corners[[1, 2, 3]] - corners[0], axis=1)
    np.testing.assert_allclose(sides, [4.0, 3.0, 5.0])


def test_shrinking_keeps_the_pixels_outer_edges():
    H = shrinking((0.5, 0.25))
    np.testing.assert_allclose(map_points(H, np.array([[-0.5, -0.5]])), [[-0.5, -0.5]])
    np.testing.assert_allclose(map_points(H, np.array([[99.5, 39.5]])), [[49.5, 9.5]])
    np.testing.assert_allclose(shrinking(0.5), shrinking((0.5, 0.5)))
    np.testing.assert_allclose(map_points(cut_from(3.0, 4.0), np.array([5.0, 5.0])), [2.0, 1.0])


def test_a_warped_grid_shows_the_same_in_place():
    cells = np.full((40, 60), FREE, dtype=np.int8)
    cells[10:14, 20:50] = OCCUPIED
    grid = GridMap(cells, 0.1, POSE)
    A_map_plan = Affine2D(np.array([[1.1, 0.2], [-0.15, 0.9]]), np.array([4.0, 1.0]))
    warped = warped_grid(grid, A_map_plan)
    rc = np.argwhere(np.ones(warped.shape, dtype=bool))
    source = grid.xy_to_rc(A_map_plan.inv().apply(warped.rc_to_xy(rc)))
    inside = ((source > 0.0) & (source < np.array(grid.shape) - 1.0)).all(axis=1)
    # Nearest neighbours differ where a cell's edge is hit to rounding only.
    clear = inside & (np.abs(source - np.floor(source) - 0.5) > 0.05).all(axis=1)
    expected = grid.cells[cells_at(source[clear], grid.shape)]
    assert (warped.cells[tuple(rc[clear].T)] == expected).mean() > 0.999
    beyond = ((source < -1.0) | (source > np.array(grid.shape))).any(axis=1)
    assert beyond.sum() > 100
    assert (warped.cells[tuple(rc[beyond].T)] == UNKNOWN).all()
    assert warped_grid(grid, Affine2D.identity()) is grid


def test_a_ray_runs_as_far_as_the_mask_goes():
    mask = np.zeros((20, 30), dtype=bool)
    mask[5, 3:18] = True
    starts = np.array([[5.0, 3.0], [5.0, 3.0], [6.0, 3.0]])
    ahead = np.array([0.0, 1.0])
    runs = run_lengths(mask, False, starts, ahead, np.array([100.0, 4.0, 4.0]))
    assert runs == pytest.approx([14.5, 4.0, 0.0])
    assert run_lengths(mask, False, starts[:1], ahead, 100.0, step=0.25) == pytest.approx(14.5)
    mask[:] = True
    assert run_lengths(mask, True, np.array([5.0, 25.0]), ahead, 40.0) == pytest.approx(40.0)
    places = np.array([[5.0, 29.6], [5.0, 29.4], [-0.6, 3.0]])
    assert marked(mask, places, False).tolist() == [False, True, False]


@pytest.mark.parametrize('ends', [[[2, 3], [25, 30]], [[25, 2], [4, 35]], [[8, 1], [8, 38]]])
def test_no_path_of_neighbours_crosses_a_line(ends):

    cells = np.zeros((30, 40), np.uint8)
    low, high = np.array(ends, float)
    along = (high - low) / np.linalg.norm(high - low)
    draw_line(cells, np.array([low - 60 * along, high + 60 * along]))
    count, _ = cv2.connectedComponents(1 - cells, connectivity=8)
    assert count == 3  # the line and both sides of it
