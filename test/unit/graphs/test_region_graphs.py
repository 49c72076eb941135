# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

from fpnet_core.geometry import Similarity2D
from fpnet_core.graphs import EDGE_FEATURES, NODE_FEATURES, build_region_graph, node_features
from fpnet_core.graphs.features import (
    AREA,
    CONFIDENCE,
    DISTANCE_UNIT_M,
    FOURIER,
    HU,
    LABEL,
    POSITION,
    POSITION_UNIT_M,
    fourier_descriptors,
    graph_centre,
    hu_moments,
)
from fpnet_core.types import GridMap, Portal, Region, RegionLabel, Segmentation

L_SHAPE = np.array([[0, 0], [7.0, 0], [7.0, 2.5], [3.0, 2.5], [3.0, 5.0], [0, 5.0]])
RECTANGLE = np.array([[0, 0], [4.0, 0], [4.0, 3.0], [0, 3.0]])
PLANTED = Similarity2D.from_scale_yaw(1.7, math.radians(37.0), [11.0, -4.0])


def shoelace(polygon):
    x, y = polygon.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def region(index, polygon, label=RegionLabel.ROOM, **extra):
    return Region(index, label, polygon, polygon.mean(axis=0), shoelace(polygon), **extra)


def door_polygon(x, y):
    return np.array([[x, y], [x + 0.1, y], [x + 0.1, y + 0.9], [x, y + 0.9]])


def two_rooms(rooms=(0, 1)):
    """Room 0 left of room 1 of another size, door 2 between them."""
    regions = (
        region(0, RECTANGLE),
        region(1, RECTANGLE * 1.5 + [4.1, 0.0]),
        region(2, door_polygon(4.0, 1.0), RegionLabel.DOOR, observed_fraction=0.5, confidence=0.8),
    )
    portal = Portal(2, rooms, np.array([[4.05, 1.0], [4.05, 1.9]]))
    grid = GridMap(np.zeros((2, 3), np.int8), 1.0)
    return Segmentation(grid, np.zeros((2, 3), np.int32), regions, (portal,))


def test_graph_has_door_room_edges_and_28_features():
    graph = build_region_graph(two_rooms(), 'plan')
    assert graph.edges.tolist() == [[0, 2], [1, 2]]
    assert graph.node_feat.shape == (3, NODE_FEATURES) == (3, 28)
    assert graph.edge_feat.shape == (2, EDGE_FEATURES)
    assert graph.node_feat.dtype == np.float32
    # 0.9 m opening, distance from door (4.05, 1.45) to room 0's centre (2, 1.5)
    expected = [1.0, math.hypot(2.05, 0.05) / DISTANCE_UNIT_M, 0.9 / DISTANCE_UNIT_M]
    assert graph.edge_feat[0] == pytest.approx(expected, abs=1e-6)


def test_door_into_unseen_space_has_one_edge():
    graph = build_region_graph(two_rooms(rooms=(0, None)), 'submap')
    assert graph.edges.tolist() == [[0, 2]]
    assert graph.frame == 'submap'


def test_two_openings_of_one_door_are_one_edge_of_the_widest():
    base = two_rooms()
    second = Portal(2, (0, 1), np.array([[4.05, 1.0], [4.05, 2.5]]))
    graph = build_region_graph(
        Segmentation(base.grid, base.labels, base.regions, (*base.portals, second)), 'plan'
    )
    assert graph.edges.tolist() == [[0, 2], [1, 2]]
    assert graph.edge_feat[:, 2] == pytest.approx(1.5 / DISTANCE_UNIT_M)


@pytest.mark.parametrize('count', [0, 1])
def test_degenerate_segmentations_give_small_graphs(count):
    grid = GridMap(np.zeros((2, 3), np.int8), 1.0)
    regions = (region(0, RECTANGLE),)[:count]
    graph = build_region_graph(Segmentation(grid, np.zeros((2, 3)), regions, ()), 'plan')
    assert graph.node_feat.shape == (count, NODE_FEATURES)
    assert graph.edges.shape == (0, 2)
    assert graph.edge_feat.shape == (0, EDGE_FEATURES)
    assert np.isfinite(graph.node_feat).all()
    assert graph.node_feat[:, POSITION].tolist() == [[0.0, 0.0]] * count


def test_node_columns_hold_what_the_layout_says():
    rows = node_features(two_rooms().regions)
    centre = graph_centre(two_rooms().regions)
    # Areas 12, 27, 0.09 m^2; centroids (2, 1.5), (7.1, 2.25), (4.05, 1.45).
    weights = np.array([12.0, 27.0, 0.09])
    expected = weights @ np.array([[2.0, 1.5], [7.1, 2.25], [4.05, 1.45]]) / weights.sum()
    assert centre == pytest.approx(expected)
    assert rows[0, POSITION] == pytest.approx(([2.0, 1.5] - expected) / POSITION_UNIT_M, abs=1e-6)
    assert rows[:, CONFIDENCE].ravel() == pytest.approx([1.0, 1.0, 0.4])
    assert rows[:, LABEL].tolist() == [[0, 1], [0, 1], [1, 0]]
    assert rows[1, AREA] - rows[0, AREA] == pytest.approx(math.log(27 / 12) / 2.0, abs=1e-6)


@pytest.mark.parametrize('polygon', [L_SHAPE, RECTANGLE], ids=['l_shape', 'rectangle'])
def test_shape_descriptors_ignore_similarity_and_start_vertex(polygon):
    moved = np.roll(PLANTED.apply(polygon), 2, axis=0)
    assert hu_moments(moved) == pytest.approx(hu_moments(polygon), abs=1e-4)
    # The start moves between samples, so the resampled outlines differ slightly at corners.
    assert fourier_descriptors(moved) == pytest.approx(fourier_descriptors(polygon), abs=0.03)


def test_hu_moments_of_a_rectangle_have_the_closed_form():
    # h1 = (w^2 + h^2) / (12 w h), h2 = ((w^2 - h^2) / (12 w h))^2, for w=4, h=3.
    h1, h2 = 25 / 144, (7 / 144) ** 2
    expected = [math.log1p(h1 / 0.01), math.log1p(h2 / 0.01), 0, 0, 0, 0, 0]
    assert hu_moments(RECTANGLE) == pytest.approx(expected, abs=1e-5)


def test_features_ignore_translation_and_turn_positions_with_the_frame():
    regions = two_rooms().regions
    turned = Similarity2D.from_scale_yaw(1.0, math.radians(37.0), [11.0, -4.0])
    moved = [
        region(r.id, turned.apply(r.polygon), r.label, observed_fraction=r.observed_fraction)
        for r in regions
    ]
    before, after = node_features(regions), node_features(moved)
    assert after[:, POSITION] == pytest.approx(before[:, POSITION] @ turned.linear.T, abs=1e-5)
    assert after[:, HU] == pytest.approx(before[:, HU], abs=1e-2)
    assert after[:, AREA] == pytest.approx(before[:, AREA], abs=1e-5)
    assert after[:, FOURIER] == pytest.approx(before[:, FOURIER], abs=0.25)


def test_shape_descriptors_tell_shapes_and_mirror_images_apart():
    assert np.abs(hu_moments(L_SHAPE) - hu_moments(RECTANGLE)).max() > 0.2
    assert np.abs(fourier_descriptors(L_SHAPE) - fourier_descriptors(RECTANGLE)).max() > 0.2
    mirrored = (L_SHAPE * [-1, 1])[::-1]
    assert hu_moments(mirrored)[6] == pytest.approx(-hu_moments(L_SHAPE)[6], abs=1e-6)


def test_fourier_descriptors_of_a_circle_and_a_point():
    angle = np.linspace(0, 2 * np.pi, 512, endpoint=False)
    circle = np.stack([3 + 2 * np.cos(angle), 1 + 2 * np.sin(angle)], axis=1)
    assert fourier_descriptors(circle) == pytest.approx(np.zeros(15), abs=0.01)
    assert fourier_descriptors(np.ones((4, 2))).tolist() == [0.0] * 15
