# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
from scipy.linalg import expm

from fpnet_core.geometry.motion import part_of, twist

velocities = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6)


def motion(velocity, seconds):
    x, y, z = velocity[3:]
    xi = np.zeros((4, 4))
    xi[:3, :3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    xi[:3, 3] = velocity[:3]
    return expm(xi * seconds)


@given(velocity=velocities, seconds=st.floats(0.05, 1.0))
def test_an_even_velocity_comes_back_from_the_motion_that_it_makes(velocity, seconds):
    np.testing.assert_allclose(twist(motion(velocity, seconds), seconds), velocity, atol=1e-6)


@given(velocity=velocities, share=st.floats(-1.0, 1.0))
def test_a_part_of_a_motion_is_that_of_a_shorter_time(velocity, share):
    part = part_of(motion(velocity, 1.0), share)
    np.testing.assert_allclose(part, motion(velocity, share), atol=1e-6)
