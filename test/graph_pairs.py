# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Toy region graphs for tests of the network: a corridor of rectangular rooms, seen in part."""

import numpy as np

from fpnet_core.geometry import SE2
from fpnet_core.graphs import build_region_graph
from fpnet_core.matches import UNMATCHED
from fpnet_core.types import GridMap, Portal, Region, RegionLabel, Segmentation


def rectangle(x, y, width, height):
    corners = [[x, y], [x + width, y], [x + width, y + height], [x, y + height]]
    return np.array(corners, dtype=np.float64)


def corridor_plan(rng, rooms):
    """Return polygons of rooms, a corridor and doors, and the two rooms of each door."""
    widths, depths = rng.uniform(2.5, 8.0, rooms), rng.uniform(3.0, 6.0, rooms)
    left = np.cumsum(widths) - widths
    polygons = [
        rectangle(left[i], 2.2 if i % 2 else -0.2 - depths[i], widths[i] - 0.2, depths[i])
        for i in range(rooms)
    ]
    polygons.append(rectangle(0.0, 0.0, float(widths.sum()), 2.0))
    links = []
    for i in range(rooms):
        offset = rng.uniform(0.2, widths[i] - 1.4)
        polygons.append(rectangle(left[i] + offset, 2.0 if i % 2 else -0.2, 0.9, 0.2))
        links.append((i, rooms))
    return polygons, links


def graph_of(polygons, links, keep, frame, pose, noise=0.0, rng=None):
    """Return the graph of the kept rooms and of the doors that touch one of them."""
    rooms = len(polygons) - len(links)
    kept_rooms = [i for i in range(rooms) if i in keep]
    kept_doors = [d for d, ends in enumerate(links) if set(ends) & keep]
    order = [*kept_rooms, *(rooms + d for d in kept_doors)]
    index = {old: new for new, old in enumerate(order)}
    regions, portals = [], []
    for old in order:
        polygon = pose.apply(polygons[old])
        if noise:
            polygon = polygon + rng.normal(0.0, noise, polygon.shape)
        x, y = polygon.T
        area = 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
        label = RegionLabel.ROOM if old < rooms else RegionLabel.DOOR
        regions.append(Region(index[old], label, polygon, polygon.mean(axis=0), max(area, 0.05)))
    for door in kept_doors:
        ends = [index[room] for room in links[door] if room in index]
        line = regions[index[rooms + door]].polygon[:2]
        portals.append(
            Portal(index[rooms + door], (ends[0], ends[1] if len(ends) > 1 else None), line)
        )
    grid = GridMap(np.zeros((1, 1), np.int8), 1.0, frame=frame)
    segmentation = Segmentation(grid, np.zeros((1, 1)), tuple(regions), tuple(portals))
    return build_region_graph(segmentation, frame), order


def toy_pair(rng, rooms=10, seen=5):
    """Return (plan graph, submap graph, labels): the submap sees a run of rooms, moved."""
    polygons, links = corridor_plan(rng, rooms)
    start = int(rng.integers(0, rooms - seen + 1))
    keep = {*range(start, start + seen), rooms}
    pose = SE2.from_xy_yaw(*rng.uniform(-9, 9, 2), rng.uniform(-np.pi, np.pi))
    plan, plan_order = graph_of(polygons, links, set(range(rooms + 1)), 'plan', SE2.identity())
    sub, sub_order = graph_of(polygons, links, keep, 'submap', pose, 0.02, rng)
    where = {old: new for new, old in enumerate(plan_order)}
    labels = np.array([where.get(old, UNMATCHED) for old in sub_order], dtype=np.int64)
    return plan, sub, labels
