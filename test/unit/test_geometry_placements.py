# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Placements as one value: the columns stay together, and the algebra is that of each one."""

import numpy as np
import pytest
from scipy.linalg import polar

from fpnet_core.geometry import SE2, Affine2D, Placement, Placements, Similarity2D, angle_between

STRETCHES = np.array(
    [[[1.1, 0.05], [0.05, 0.9]], [[0.7, -0.2], [-0.2, 1.4]], [[3.0, 0], [0, 0.2]]]
)
HEADINGS = np.array([0.4, -2.9, 2.2])
SHIFTS = np.array([[3.0, -7.0], [0.0, 12.5], [-40.0, 0.3]])
POINTS = np.array([[0.0, 0.0], [8.0, 1.0], [-3.0, 5.0]])
SPREAD = np.array([[0.04, 0.01, 0.002], [0.01, 0.09, -0.001], [0.002, -0.001, 0.0004]])


def rotation(yaw):
    return SE2.from_xy_yaw(0.0, 0.0, yaw).linear


def planted():
    """Three placements that share no column."""
    linear = np.array([S @ rotation(yaw) for S, yaw in zip(STRETCHES, HEADINGS, strict=True)])
    cov = SPREAD * np.array([1.0, 2.0, 3.0])[:, None, None]
    return Placements(linear, SHIFTS, [0.9, 0.8, 0.3], cov, [0.7, 0.2, 0.05])


def assert_same(a, b):
    for name in ('linear', 'translation', 'score', 'cov', 'probability'):
        np.testing.assert_allclose(getattr(a, name), getattr(b, name), atol=1e-12, err_msg=name)


def test_polar_parts_are_those_that_were_planted():
    placed = planted()
    np.testing.assert_allclose(placed.heading, HEADINGS, atol=1e-12)
    np.testing.assert_allclose(placed.stretch, STRETCHES, atol=1e-12)
    np.testing.assert_allclose(placed.scale, np.sqrt(np.linalg.det(STRETCHES)), atol=1e-12)
    assert (placed.stretch == placed.stretch.transpose(0, 2, 1)).all()


@pytest.mark.parametrize('seed', range(5))
def test_polar_parts_are_those_of_the_general_decomposition(seed):
    linear = np.random.default_rng(seed).normal(size=(50, 2, 2))
    linear = linear[np.linalg.det(linear) > 0.0]
    placed = Placements(linear, np.zeros((len(linear), 2)))
    for each, heading, stretch in zip(linear, placed.heading, placed.stretch, strict=True):
        R, P = polar(each, side='left')
        np.testing.assert_allclose(stretch, P, atol=1e-9)
        assert angle_between(heading, np.arctan2(R[1, 0], R[0, 0])) < 1e-6


def test_points_land_where_each_transform_puts_them():
    placed = planted()
    assert placed.apply(POINTS).shape == (3, 3, 2)
    expected = [each.A_plan_submap.apply(POINTS) for each in placed]
    np.testing.assert_allclose(placed.apply(POINTS), expected, atol=1e-12)
    np.testing.assert_array_equal(placed.matrix, [each.A_plan_submap.matrix for each in placed])


@pytest.mark.parametrize(
    'A', [Affine2D([[0.9, 0.3], [-0.1, 1.2]], [5.0, -2.0]), SE2.from_xy_yaw(-3.0, 1.0, 2.5)]
)
def test_composition_on_either_side_is_that_of_each_transform(A):
    placed = planted()
    before, after = placed @ A, A @ placed
    for index, each in enumerate(placed):
        np.testing.assert_allclose(before.matrix[index], (each.A_plan_submap @ A).matrix)
        np.testing.assert_allclose(after.matrix[index], (A @ each.A_plan_submap).matrix)
    for composed in (before, after):
        np.testing.assert_array_equal(composed.score, placed.score)
        np.testing.assert_array_equal(composed.probability, placed.probability)


def test_covariances_follow_the_frames():
    """Draws of the origin's pose, moved one by one, scatter as the composed value says."""
    placed = planted().take(np.s_[:1])
    small = 1e-3 * np.random.default_rng(0).multivariate_normal(np.zeros(3), SPREAD, size=20_000)
    linear, shift = placed.linear[0], placed.translation[0]
    turned = np.array([rotation(yaw) @ linear for yaw in small[:, 2]])
    draws = Placements(turned, shift + small[:, :2])
    inner, outer = SE2.from_xy_yaw(6.0, -4.0, 0.8), Similarity2D.from_scale_yaw(1.5, -1.0, [2, 1])
    for moved, whole in ((draws @ inner, placed @ inner), (outer @ draws, outer @ placed)):
        directions = moved.linear[:, :, 0]
        yaw = np.arctan2(directions[:, 1], directions[:, 0])
        poses = np.column_stack([moved.translation, np.unwrap(yaw)])
        scatter = np.cov(poses.T) / 1e-6
        limit = 0.03 * np.sqrt(np.outer(np.diag(whole.cov[0]), np.diag(whole.cov[0])))
        assert (np.abs(scatter - whole.cov[0]) < limit).all()


def test_columns_stay_together():
    placed = planted()
    swapped = placed.take(np.array([2, 0]))
    assert_same(swapped, Placements.of([placed[2], placed[0]]))
    assert_same(placed.take(np.array([True, False, True])), Placements.of([placed[0], placed[2]]))
    assert_same(
        placed.take(np.s_[1:]).joined(placed.take(np.s_[:1])), placed.take(np.array([1, 2, 0]))
    )
    assert_same(Placements.empty().joined(placed), placed)
    assert placed[-1].score == 0.3
    assert [each.probability for each in placed] == [0.7, 0.2, 0.05]
    assert len(placed.take(np.zeros(0, np.int64))) == 0


def test_no_placement_is_a_value_like_any_other():
    nothing = Placements.empty()
    assert not nothing
    assert list(nothing) == []
    assert nothing.apply(POINTS).shape == (0, 3, 2)
    assert nothing.distinct(POINTS, 1.0, 5).shape == (0,)
    assert len(nothing @ SE2.identity()) == len(SE2.identity() @ nothing) == 0
    assert nothing.stretch.shape == nothing.matrix[:, :2, :2].shape == (0, 2, 2)


def test_a_worse_placement_near_a_better_one_is_the_same_one():
    at = [0.0, 0.4, 3.0, 2.8, 0.8, 9.0]
    ranked = Placements.of(SE2.from_xy_yaw(x, 0.0, 0.0) for x in at)
    # The fifth is far from the first, and near to what has been dropped.
    assert ranked.distinct(POINTS, 0.5, 9).tolist() == [0, 2, 4, 5]
    assert ranked.distinct(POINTS, 0.5, 2).tolist() == [0, 2]
    assert ranked.take(np.s_[::-1]).distinct(POINTS, 0.5, 9).tolist() == [0, 1, 2, 5]


@pytest.mark.parametrize(
    ('column', 'value'),
    [
        ('linear', np.zeros((3, 3, 3))), ('translation', np.zeros((2, 2))),
        ('score', np.zeros(2)), ('cov', np.zeros((3, 2, 2))), ('probability', np.zeros((3, 1))),
    ],
)  # fmt: skip
def test_a_wrong_shape_is_refused_by_name(column, value):
    columns = {'linear': STRETCHES, 'translation': SHIFTS, column: value}
    with pytest.raises(ValueError, match=rf'Placements\.{column}: expected shape'):
        Placements(**columns)


def test_one_placement_refuses_what_it_cannot_be():
    with pytest.raises(ValueError, match=r'cov.*shape'):
        Placement(SE2.identity(), 0.5, np.eye(2))
    with pytest.raises(ValueError, match=r'cov.*NaN'):
        Placement(SE2.identity(), 0.5, np.full((3, 3), np.nan))
    unusable = Placements(np.full((1, 2, 2), np.nan), np.zeros((1, 2)))
    with pytest.raises(ValueError, match='NaN'):
        _ = unusable[0]
