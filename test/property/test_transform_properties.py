# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Group laws of the planar transforms, and the raster's two-way map."""

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest

from fpnet_core.geometry import SE2, Affine2D, Similarity2D, angle_between, wrap_to_pi
from fpnet_core.types import GridMap

coordinates = st.floats(-100.0, 100.0)
angles = st.floats(-10.0, 10.0)
rigid = st.builds(SE2.from_xy_yaw, coordinates, coordinates, angles)
similar = st.builds(
    lambda scale, yaw, x, y: Similarity2D.from_scale_yaw(scale, yaw, [x, y]),
    st.floats(0.2, 5.0),
    angles,
    coordinates,
    coordinates,
)
affine = st.builds(
    lambda S, shear, stretch: S @ Affine2D(np.array([[1.0, shear], [0.0, stretch]]), np.zeros(2)),
    similar,
    st.floats(-0.5, 0.5),
    st.floats(0.5, 2.0),
)
points = st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=5).map(np.array)


@given(affine, points)
def test_the_inverse_takes_points_back(A, xy):
    np.testing.assert_allclose(A.inv().apply(A.apply(xy)), xy, atol=1e-6)


@given(affine, similar, rigid, points)
def test_composition_is_application_in_turn_and_associative(A, S, T, xy):
    np.testing.assert_allclose((A @ S @ T).apply(xy), A.apply(S.apply(T.apply(xy))), atol=1e-6)
    np.testing.assert_allclose(((A @ S) @ T).matrix, (A @ (S @ T)).matrix, atol=1e-6)


@given(rigid, similar, affine)
def test_composition_stays_in_the_smallest_group(T, S, A):
    assert type(T @ T.inv()) is SE2
    assert type(T @ S) is type(S @ T) is Similarity2D
    assert type(A @ T) is type(S @ A) is Affine2D


@given(rigid, angles)
def test_headings_turn_with_the_frame(T, yaw):
    assert angle_between(T.apply_yaw(yaw), T.yaw + yaw) < 1e-9


@given(affine, similar)
def test_mean_scales_multiply_and_are_those_of_the_smaller_group(A, S):
    assert Affine2D(S.linear, S.translation).scale == pytest.approx(S.scale, rel=1e-9)
    assert (A @ S).scale == pytest.approx(A.scale * S.scale, rel=1e-9)


@given(angles)
def test_wrapping_keeps_the_direction_in_a_half_open_range(angle):
    wrapped = float(wrap_to_pi(angle))
    assert -np.pi < wrapped <= np.pi
    assert np.cos(wrapped) == pytest.approx(np.cos(angle), abs=1e-9)
    assert np.sin(wrapped) == pytest.approx(np.sin(angle), abs=1e-9)


@given(rigid, st.floats(0.01, 0.2), points)
def test_raster_indices_and_metres_are_inverse(T, resolution, rc):
    grid = GridMap(np.zeros((3, 4), dtype=np.int8), resolution, T)
    np.testing.assert_allclose(grid.xy_to_rc(grid.rc_to_xy(rc)), rc, atol=1e-5)


def test_the_first_cell_lies_half_a_cell_inside_the_origin():
    grid = GridMap(np.zeros((3, 4), np.int8), 0.5, SE2.from_xy_yaw(2.0, 1.0, np.pi / 2))
    # Column grows along the frame's y, row against its x: (row 0, col 1) is 0.75 along y.
    np.testing.assert_allclose(grid.rc_to_xy([0, 1]), [2.0 - 0.25, 1.0 + 0.75])


@pytest.mark.parametrize(
    ('make', 'message'),
    [
        (lambda: SE2(2.0 * np.eye(2), np.zeros(2)), 'scale 2'),
        (lambda: Similarity2D(np.diag([1.0, -1.0]), np.zeros(2)), 'not a scaled rotation'),
        (lambda: Affine2D(np.ones((2, 2)), np.zeros(2)), 'singular'),
        (lambda: Affine2D(np.eye(3), np.zeros(2)), 'expected linear'),
        (lambda: Affine2D(np.eye(2), np.array([np.nan, 0.0])), 'NaN'),
        (lambda: SE2.from_matrix(np.eye(4)), r'\(4, 4\)'),
    ],
)
def test_what_is_not_in_the_group_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_transform_cannot_be_changed():
    T = SE2.from_xy_yaw(1.0, 2.0, 0.3)
    with pytest.raises(ValueError, match='read-only'):
        T.linear[0, 0] = 5.0
