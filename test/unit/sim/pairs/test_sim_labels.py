# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.matches import IGNORE, UNMATCHED
from fpnet_core.types import FREE, GridMap, Portal, Region, RegionLabel, Segmentation
from fpnet_lab.sim.pairs.labels import Relation, label_regions

# Turned by no multiple of 90 degrees, unequal scales and shift: nothing may be swapped.
A_PLAN_SUBMAP = Affine2D(
    np.diag([1.04, 0.95]) @ np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]]),
    np.array([11.0, -4.0]),
)


def _segmentation(boxes, doors, T_frame_building, resolution=0.1):
    """Segment axis-parallel ``boxes`` of a building as seen from a transformed frame."""
    corners = np.array([[-2, -2], [22, -2], [22, 14], [-2, 14]], dtype=float)
    seen = T_frame_building.apply(corners)
    origin = seen.min(axis=0)
    cols, rows = np.ceil((seen.max(axis=0) - origin) / resolution).astype(int)
    cells = np.full((rows, cols), FREE, np.int8)
    grid = GridMap(cells, resolution, SE2.from_xy_yaw(*origin, 0.0))
    rc = np.stack(np.meshgrid(np.arange(rows), np.arange(cols), indexing='ij'), axis=-1)
    xy = T_frame_building.inv().apply(grid.rc_to_xy(rc))
    labels = np.zeros((rows, cols), np.int32)
    regions = []
    scale = abs(np.linalg.det(T_frame_building.linear))
    for x0, y0, x1, y1 in boxes:
        inside = (xy[..., 0] > x0) & (xy[..., 0] < x1) & (xy[..., 1] > y0) & (xy[..., 1] < y1)
        labels[inside] = len(regions) + 1
        ring = T_frame_building.apply([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        area = (x1 - x0) * (y1 - y0) * scale
        regions.append(Region(len(regions), RegionLabel.ROOM, ring, ring.mean(axis=0), area))
    portals = []
    for ends in doors:
        moved = T_frame_building.apply(ends)
        ring = np.vstack([moved + 0.1, moved[::-1] - 0.1])
        regions.append(Region(len(regions), RegionLabel.DOOR, ring, moved.mean(axis=0), 0.2))
        portals.append(Portal(len(regions) - 1, (0, None), moved))
    return Segmentation(grid, labels, tuple(regions), tuple(portals))


ROOMS = [(0, 0, 10, 4), (0, 5, 5, 11), (6, 5, 12, 11)]
DOORS = [[[2, 4.5], [3, 4.5]], [[8, 4.5], [8.9, 4.5]]]
T_SUB = A_PLAN_SUBMAP.inv()


@pytest.fixture
def plan():
    return _segmentation(ROOMS, DOORS, Affine2D.identity())


def test_the_same_rooms_in_another_order_find_their_partners(plan):
    sub = _segmentation([ROOMS[2], ROOMS[0], ROOMS[1]], DOORS[::-1], T_SUB)
    assert label_regions(plan, sub, A_PLAN_SUBMAP).labels.tolist() == [2, 0, 1, 4, 3]


def test_doors_need_the_place_and_the_direction(plan):
    near = [[2.2, 4.6], [3.2, 4.6]]
    crossed = [[8.45, 4.0], [8.45, 5.0]]
    far = [[14.0, 9.0], [15.0, 9.0]]
    sub = _segmentation([ROOMS[0]], [near, crossed, far], T_SUB)
    assert label_regions(plan, sub, A_PLAN_SUBMAP).labels.tolist() == [0, 3, IGNORE, UNMATCHED]


def test_two_doors_never_share_a_partner(plan):
    sub = _segmentation([ROOMS[0]], [DOORS[0], [[2.3, 4.5], [3.3, 4.5]]], T_SUB)
    assert label_regions(plan, sub, A_PLAN_SUBMAP).labels.tolist() == [0, 3, IGNORE]


def _relations(plan, boxes):
    return label_regions(plan, _segmentation(boxes, [], T_SUB), A_PLAN_SUBMAP).relations.tolist()


def test_relations_tell_whole_partial_split_merged_and_foreign_rooms(plan):
    assert _relations(plan, [ROOMS[0]]) == [Relation.MATCHED]
    assert _relations(plan, [(0, 0, 3, 4)]) == [Relation.MATCHED | Relation.PARTIAL]
    split = Relation.PARTIAL | Relation.SPLIT
    assert _relations(plan, [(0, 0, 3.5, 4), (4, 0, 10, 4)]) == [split, split | Relation.MATCHED]
    assert _relations(plan, [(0, 5, 12, 11)]) == [Relation.MATCHED | Relation.MERGED]
    assert _relations(plan, [(14, 6, 19, 11)]) == [0]
