# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One place in every frame: transforms, covariances and hints."""

import numpy as np
from planted import plan_grid
import pytest

from fpnet_core.errors import HintError
from fpnet_core.geometry import SE2, Affine2D, Placements, Similarity2D
from fpnet_core.localizer.hint import PoseHint
from fpnet_core.localizer.map_frame import MapFrame
from fpnet_core.pose_covariance import Growth, PoseCovariance, PoseFeatures
from fpnet_core.types import LocalizerOutput, Status

STRETCH = np.array([[1.08, 0.02], [0.02, 0.95]])
RIGID = SE2.from_xy_yaw(0.0, 0.0, 0.7)
SHIFT = np.array([12.0, -3.0])
A_PLAN_ODOM = Affine2D(STRETCH @ RIGID.linear, SHIFT)
ROBOT = np.array([4.0, 9.0])


def test_a_stretched_drawing_gives_the_rigid_transform_of_the_definition():
    frame = MapFrame(plan_grid()).followed(A_PLAN_ODOM)
    np.testing.assert_allclose(frame.A_map_plan.linear, np.linalg.inv(STRETCH), atol=1e-12)
    T_map_odom = frame.T_map_odom(A_PLAN_ODOM, ROBOT)
    np.testing.assert_allclose(T_map_odom.linear, RIGID.linear, atol=1e-12)
    np.testing.assert_allclose(T_map_odom.translation, np.linalg.inv(STRETCH) @ SHIFT, atol=1e-12)


def test_small_changes_of_scale_move_neither_the_drawing_nor_the_robot_on_it():
    frame = MapFrame(plan_grid()).followed(A_PLAN_ODOM)
    held = frame.A_map_plan
    slightly = Affine2D(1.001 * A_PLAN_ODOM.linear, SHIFT)
    assert frame.followed(slightly) is frame
    in_map = frame.T_map_odom(slightly, ROBOT).apply(ROBOT)
    np.testing.assert_allclose(in_map, held.apply(slightly.apply(ROBOT)), atol=1e-12)


def test_a_trusted_drawing_is_the_map():
    frame = MapFrame(plan_grid(), 'map', 'map')
    assert frame.followed(A_PLAN_ODOM) is frame
    np.testing.assert_array_equal(frame.A_map_plan.matrix, np.eye(3))
    in_map = frame.T_map_odom(A_PLAN_ODOM, ROBOT).apply(ROBOT)
    np.testing.assert_allclose(in_map, A_PLAN_ODOM.apply(ROBOT), atol=1e-12)


def test_the_covariance_is_that_of_the_robot():
    """The spread of sampled placements, carried on by odometry, is what the covariance says."""
    sigma = np.diag([0.1, 0.2, 0.01]) ** 2
    at_tick = np.array([1.0, 2.0])
    nothing = Growth(0.0, 0.0, 0.0, 0.0)
    covariance = PoseCovariance(sigma, at_tick, 5, nothing, PoseFeatures(np.eye(3), np.zeros(1)))
    output = LocalizerOutput(5, Status.LOCALIZED, A_PLAN_ODOM, covariance)
    frame = MapFrame(plan_grid()).followed(A_PLAN_ODOM)
    draws = np.random.default_rng(3).multivariate_normal(np.zeros(3), sigma, 20_000)
    in_map = []
    for x, y, yaw in draws:
        turn = SE2.from_xy_yaw(0.0, 0.0, yaw).linear
        away = turn @ A_PLAN_ODOM.linear @ (ROBOT - at_tick)
        xy = A_PLAN_ODOM.apply(at_tick) + away + np.array([x, y])
        in_map.append((*frame.A_map_plan.apply(xy), yaw))
    located = frame.located(output, SE2.from_xy_yaw(*ROBOT, 0.4).as_matrix4(), 5)
    np.testing.assert_allclose(located.cov, np.cov(np.array(in_map).T), atol=1.5e-3)
    np.testing.assert_allclose(located.cov[2, 2], sigma[2, 2], rtol=1e-12)


def test_one_output_says_the_same_place_in_every_frame():
    output = LocalizerOutput(0, Status.LOCALIZED, A_PLAN_ODOM)
    frame = MapFrame(plan_grid()).followed(A_PLAN_ODOM)
    T_odom_base = SE2.from_xy_yaw(*ROBOT, 0.3)
    located = frame.located(output, T_odom_base.as_matrix4(), 0)
    in_plan = A_PLAN_ODOM.apply(ROBOT)
    np.testing.assert_allclose(located.T_plan_base.translation, in_plan, atol=1e-12)
    np.testing.assert_allclose(
        located.T_map_base.translation, frame.A_map_plan.apply(in_plan), atol=1e-12
    )
    np.testing.assert_allclose(
        (located.T_map_odom @ T_odom_base).matrix, located.T_map_base.matrix, atol=1e-12
    )
    assert located.cov is None
    assert frame.located(LocalizerOutput(0, Status.LOST), T_odom_base.as_matrix4(), 0) is None


def test_a_word_in_either_frame_is_the_same_hint():
    frame = MapFrame(plan_grid(), 'drawing', 'map').followed(A_PLAN_ODOM)
    in_plan = SE2.from_xy_yaw(*A_PLAN_ODOM.apply(ROBOT), A_PLAN_ODOM.apply_yaw(0.4))
    x, y = frame.A_map_plan.apply(in_plan.translation)
    in_map = SE2.from_xy_yaw(float(x), float(y), frame.A_map_plan.apply_yaw(in_plan.yaw))
    T_odom_base = SE2.from_xy_yaw(*ROBOT, 0.4)
    cov = np.diag([0.04, 0.25, 0.09])
    for given, frame_id in ((in_plan, 'drawing'), (in_map, 'map')):
        hint = frame.hint(given, frame_id, cov, T_odom_base.as_matrix4())
        np.testing.assert_allclose(hint.T_plan_base.matrix, in_plan.matrix, atol=1e-9)
        np.testing.assert_allclose(hint.T_odom_base.matrix, T_odom_base.matrix, atol=1e-12)
        assert (hint.position_sigma_m, hint.yaw_sigma_rad) == pytest.approx((0.5, 0.3))


def test_a_word_on_a_place_off_the_drawing_is_refused():
    frame = MapFrame(plan_grid(), 'drawing', 'map')
    corner = plan_grid().rc_to_xy([0, 0])
    outward = corner - plan_grid().rc_to_xy(np.array(plan_grid().shape) / 2.0)
    outward /= np.linalg.norm(outward)
    near, far = (SE2.from_xy_yaw(*(corner + d * outward), 0.0) for d in (1.5, 30.0))
    frame.hint(near, 'drawing', np.zeros((3, 3)), np.eye(4))
    with pytest.raises(HintError, match='m outside the floorplan'):
        frame.hint(far, 'drawing', np.zeros((3, 3)), np.eye(4))
    frame.hint(far, 'drawing', np.diag([400.0, 400.0, 0.1]), np.eye(4))


@pytest.mark.parametrize(
    ('plan_id', 'message'),
    [('drawing', "expected 'map' or 'drawing'"), ('map', "expected 'map'$")],
)
def test_a_word_in_another_frame_is_refused(plan_id, message):
    frame = MapFrame(plan_grid(), plan_id, 'map')
    with pytest.raises(HintError, match=message):
        frame.hint(SE2.identity(), 'odom', np.eye(3), np.eye(4))


@pytest.mark.parametrize('scale', [0.7, 1.0, 1.4])
def test_a_hint_is_for_placements_of_any_scale_that_put_the_robot_there(scale):
    here = SE2.from_xy_yaw(10.0, -4.0, 0.3)  # far from where odometry began
    there = SE2.from_xy_yaw(2.0, 5.0, -1.1)
    hint = PoseHint(there, here)
    linear = Similarity2D.from_scale_yaw(scale, there.yaw - here.yaw, (0.0, 0.0))
    around_robot = Similarity2D.from_scale_yaw(
        scale, there.yaw - here.yaw, there.translation - linear.apply(here.translation)
    )
    assert hint.agrees(around_robot)
    turned = around_robot @ here @ SE2.from_xy_yaw(0.0, 0.0, 0.8) @ here.inv()
    around_start = Similarity2D.from_scale_yaw(
        scale, there.yaw - here.yaw, hint.A_plan_odom.translation
    )
    found = Placements.of([turned, around_robot, around_start])
    expected = [False, True, scale == 1.0]
    assert hint.agreeing(found, SE2.from_xy_yaw(0.0, 0.0, 0.0)).tolist() == expected
