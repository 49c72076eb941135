# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Transforms of messages as plain values."""

from types import SimpleNamespace as Message

import pytest

from fpnet_core.io.messages import transforms_of


def said(parent, child, xyz, xyzw):
    header = Message(frame_id=parent, stamp=Message(sec=3, nanosec=5))
    place = Message(
        translation=Message(**dict(zip('xyz', xyz, strict=True))),
        rotation=Message(**dict(zip('xyzw', xyzw, strict=True))),
    )
    return Message(header=header, child_frame_id=child, transform=place)


# A third of a turn about x = y = z takes x to y: (1, 1, 1, 1) / 2, and twice as long here.
TURNED = said('/base', '/lidar', (1.0, -2.0, 0.5), (1.0, 1.0, 1.0, 1.0))
BROKEN = said('base', 'camera', (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))


def test_what_is_asked_for_one_frame_does_not_fail_for_another():
    message = Message(transforms=[BROKEN, TURNED])
    assert [each.child for each in transforms_of(message, 'lidar')] == ['lidar']
    with pytest.raises(ValueError, match='quaternion is zero'):
        list(transforms_of(message))
