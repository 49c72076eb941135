# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import numpy as np
from planted import plan_grid
import pytest
from visualization_msgs.msg import Marker

from fpnet_core.config import SegmentationConfig
from fpnet_core.geometry import SE2, Affine2D, Placement, Placements
from fpnet_core.graphs import build_region_graph
from fpnet_core.matches import MatchResult
from fpnet_core.segmentation import segment_floorplan
from fpnet_core.types import LocalizerOutput, Status
from msg_adapters.markers import (
    hypothesis_markers,
    markers_to_msg,
    match_markers,
    region_markers,
    way_markers,
)

A_MAP_PLAN = Affine2D(np.diag([0.9, 1.1]), np.zeros(2))


@pytest.fixture(scope='module')
def segmentation():
    return segment_floorplan(plan_grid(), SegmentationConfig())


@pytest.fixture(scope='module')
def graph(segmentation):
    return build_region_graph(segmentation, 'plan')


def _xy(marker):
    return np.array([(point.x, point.y) for point in marker.points])


def test_regions_are_drawn_where_they_are(segmentation, graph, received):
    markers = region_markers(segmentation, graph, A_MAP_PLAN, 7, 'map', 'plan')
    rooms, doors, edges = received(markers_to_msg(markers)).markers[1:]
    assert [m.ns for m in (rooms, doors, edges)] == ['plan_rooms', 'plan_doors', 'plan_edges']
    assert {m.header.frame_id for m in (rooms, doors, edges)} == {'map'}
    corners = A_MAP_PLAN.apply(np.concatenate([r.polygon for r in segmentation.rooms]))
    np.testing.assert_allclose(_xy(rooms).min(axis=0), corners.min(axis=0))
    assert len(doors.points) == 2 * len(segmentation.portals)
    assert len(edges.points) == 2 * len(graph.edges)
    first = A_MAP_PLAN.apply(graph.regions[graph.edges[0, 0]].centroid)
    np.testing.assert_allclose(_xy(edges)[0], first)


def test_the_array_replaces_what_was_shown_before():
    assert markers_to_msg([]).markers[0].action == Marker.DELETEALL


def test_matches_are_coloured_by_score_and_need_a_placement(graph):
    estimates = Placements.of([Placement(Affine2D.identity(), 0.8, np.eye(3))])
    match = MatchResult([[0, 1], [2, 0]], [0.1, 0.9], np.zeros((len(graph), len(graph))))
    output = LocalizerOutput(0, Status.AMBIGUOUS, estimates=estimates, match=match, graph=graph)
    (marker,) = match_markers(graph, output, A_MAP_PLAN, 0, 'map')
    np.testing.assert_allclose(_xy(marker)[1], A_MAP_PLAN.apply(graph.regions[1].centroid))
    assert marker.colors[0].r > marker.colors[0].g
    assert marker.colors[3].g > marker.colors[3].r
    without = LocalizerOutput(0, Status.SEARCHING, match=match, graph=graph)
    assert match_markers(graph, without, A_MAP_PLAN, 0, 'map') == []


def test_hypotheses_show_where_the_robot_would_be():
    A_plan_submap = SE2.from_xy_yaw(2.0, 0.0, np.pi / 2)
    estimates = Placements.of(Placement(A_plan_submap, score) for score in (0.9, 0.5))
    base = SE2.from_xy_yaw(1.0, 0.0, 0.0)
    best, rival = hypothesis_markers(estimates, A_MAP_PLAN, base, 0, 'map')
    np.testing.assert_allclose((best.pose.position.x, best.pose.position.y), (1.8, 1.1))
    assert best.pose.orientation.z == pytest.approx(np.sqrt(0.5))
    assert best.color.a > rival.color.a
    assert (best.id, rival.id) == (0, 1)


def test_a_way_is_a_line_from_its_beginning_to_its_end():
    way = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]])
    (marker,) = way_markers(way, 7, 'odom')
    assert (marker.ns, marker.header.frame_id) == ('next_look', 'odom')
    np.testing.assert_allclose(_xy(marker), way[[0, 1, 1, 2]])
    assert way_markers(way[:1], 7, 'odom') == []
