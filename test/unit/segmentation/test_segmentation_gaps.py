# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Openings that walls end at, drawn at odd angles."""

import cv2
import numpy as np
import pytest

from fpnet_core.config import SegmentationConfig
from fpnet_core.segmentation import gaps, segment_floorplan
from fpnet_core.segmentation.gaps import find_gaps, openings_across
from fpnet_core.types import FREE, OCCUPIED, GridMap

CONFIG = SegmentationConfig()
CELL_M = 0.05


def drawing(walls, angle_deg, size_m=(12.0, 9.0)):
    """Free cells of a room of ``size_m`` with walls (x0, y0, x1, y1) [m], turned."""
    middle = np.array([10.0, 10.0])
    angle = np.deg2rad(angle_deg)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    blocked = np.ones((400, 400), dtype=np.uint8)

    def fill(box, value):
        x0, y0, x1, y1 = box
        corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) - np.array(size_m) / 2.0
        px = (corners @ turn.T + middle) / CELL_M - 0.5
        cv2.fillPoly(blocked, [np.rint(px * 16).astype(np.int32)], value, shift=4)

    fill((0.0, 0.0, *size_m), 0)
    for wall in walls:
        fill(wall, 1)
    return blocked == 0


ANGLES = [0.0, 21.7, 45.0, 118.3]
# A wall across the room with one opening 2.8 m wide, between jambs 0.8 m long and more.
WIDE = [(5.9, 0.0, 6.1, 0.8), (5.9, 3.6, 6.1, 9.0)]
# A row of cubicles: partitions that end in the room, with a short front on one side only.
CUBICLES = [
    box
    for k in range(4)
    for box in [
        (3.0 * k - 0.1, 6.0, 3.0 * k + 0.1, 9.0),
        (3.0 * k - 0.1, 6.0, 3.0 * k + 0.7, 6.2),
    ]
]


@pytest.mark.parametrize('angle_deg', ANGLES)
def test_wide_opening_between_jambs_parts_two_rooms(angle_deg):
    free = drawing(WIDE, angle_deg)
    (gap,) = find_gaps(free, ~free, CELL_M)
    assert np.hypot(*(gap[1] - gap[0])) * CELL_M == pytest.approx(2.8, abs=0.15)
    segmentation = segment_floorplan(GridMap(np.where(free, FREE, OCCUPIED), CELL_M), CONFIG)
    assert [room.area_m2 for room in segmentation.rooms] == pytest.approx([53.1, 53.1], abs=0.9)
    (portal,) = segmentation.portals
    assert portal.width_m == pytest.approx(2.8, abs=0.15)


@pytest.mark.parametrize('angle_deg', ANGLES)
def test_cubicles_open_to_the_room_in_front(angle_deg):
    free = drawing(CUBICLES, angle_deg)
    segmentation = segment_floorplan(GridMap(np.where(free, FREE, OCCUPIED), CELL_M), CONFIG)
    # The cubicle in the corner, with a wall's end on one side of its mouth only, may stay open.
    assert len(segmentation.rooms) in (4, 5)
    assert len(segmentation.portals) == len(segmentation.rooms) - 1
    assert {0} < set.union(*(set(portal.rooms) for portal in segmentation.portals))
    assert all(0 in portal.rooms for portal in segmentation.portals)


# A hall with cut-off corners, from one of which a corridor 2 m wide leads away [m].
BENT = [(-1.0, 6.0), (-1.0, 2.0), (-5.0, -2.0), (-5.0, -6.0), (5.0, -6.0), (5.0, -2.0), (1.0, 2.0)]


@pytest.mark.parametrize('angle_deg', ANGLES)
def test_a_gap_is_square_to_the_corridor_that_a_bent_wall_opens_to(angle_deg):
    angle = np.deg2rad(angle_deg)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    ring, mouth = np.array([*BENT, (1.0, 6.0)]) @ turn.T + 10.0, turn @ (0.0, 2.0) + 10.0
    free = np.zeros((400, 400), dtype=np.uint8)
    cv2.fillPoly(free, [np.rint((ring / CELL_M - 0.5) * 16).astype(np.int32)], 1, shift=4)
    gaps_found = np.array(find_gaps(free == 1, free == 0, CELL_M))
    lengths = np.hypot(*(gaps_found[:, 1] - gaps_found[:, 0]).T) * CELL_M
    middles = (gaps_found.mean(axis=1)[:, ::-1] + 0.5) * CELL_M
    assert lengths == pytest.approx(2.0, abs=0.15)
    assert np.hypot(*(middles - mouth).T) == pytest.approx(0.0, abs=0.15)


@pytest.mark.parametrize('angle_deg', ANGLES)
def test_corridor_corner_is_no_gap(angle_deg):
    free = drawing([(0.0, 2.0, 10.0, 9.0)], angle_deg)
    assert find_gaps(free, ~free, CELL_M) == []


def test_an_opening_wider_than_any_gap_joins(monkeypatch):
    monkeypatch.setattr(gaps, 'GAP_WIDTH_M', 2.0)
    free = drawing(WIDE, 21.7)
    assert find_gaps(free, ~free, CELL_M) == []


def test_gap_onto_a_partition_is_two_openings():
    labels = np.ones((60, 100), dtype=np.int32)
    labels[30:, :50], labels[30:, 50:] = 2, 3
    gap = np.array([[30.0, 20.0], [30.0, 80.0]])
    openings = openings_across([gap], labels, CELL_M)
    assert sorted(opening.rooms for opening in openings) == [(1, 2), (1, 3)]
    assert [opening.clearance_m for opening in openings] == pytest.approx([0.75, 0.75], abs=0.05)
    assert openings_across([gap], np.ones_like(labels), CELL_M) == []
