# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A lift that shuts and opens is noticed; rooms, half a view and a moment are not."""

import numpy as np
import pytest

from fpnet_core.sites.cabin import CabinWatch, is_shut_in

SCAN_NS = 100_000_000
LEVEL = np.eye(4)


def box(length_m, width_m, rays=360, view=2.0 * np.pi, at=(0.2, -0.1)):
    """Returns (P, 3) from inside a box, of a sensor that looks ahead."""
    angle = np.linspace(-0.5 * view, 0.5 * view, rays, endpoint=False)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    half = 0.5 * np.array([length_m, width_m])
    reach = np.min((np.sign(ray) * half - at) / np.where(ray == 0.0, 1e-9, ray), axis=1)
    return np.column_stack([ray * reach[:, None], np.zeros(rays)]).astype(np.float32)


def opened(points):
    """The same with a doorway ahead that leads 8 m far."""
    angle = np.arctan2(points[:, 1], points[:, 0])
    far = np.where(np.abs(angle) < 0.5, 8.0 / np.hypot(points[:, 0], points[:, 1]), 1.0)
    return (points * far[:, None]).astype(np.float32)


def test_a_cabin_is_shut_and_a_room_is_not():
    assert is_shut_in(box(1.4, 2.4), LEVEL)
    assert not is_shut_in(opened(box(1.4, 2.4)), LEVEL)
    assert not is_shut_in(box(4.0, 7.0), LEVEL)


def test_who_looks_ahead_only_cannot_tell():
    assert not is_shut_in(box(1.4, 2.4, view=np.pi), LEVEL)
    assert not is_shut_in(np.zeros((0, 3), dtype=np.float32), LEVEL)


@pytest.mark.parametrize('scans', [5, 30])
def test_it_takes_a_while_and_ends_at_once(scans):
    watch = CabinWatch()
    inside = [watch.follow(k * SCAN_NS, box(2.0, 2.0), LEVEL) for k in range(scans)]
    assert sum(inside) == (scans > 10)
    assert watch.is_shut is (scans > 10)
    assert watch.follow(scans * SCAN_NS, opened(box(2.0, 2.0)), LEVEL) is (scans > 10)
    assert not watch.is_shut
    assert not watch.follow((scans + 1) * SCAN_NS, box(2.0, 2.0), LEVEL)
