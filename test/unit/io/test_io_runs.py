# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ticks in files: every field of every type comes back; damage ends in one error."""

from dataclasses import fields, is_dataclass, replace
from enum import Enum
import json
from types import UnionType
from typing import Literal, Union, get_args, get_origin, get_type_hints

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2, Affine2D, Placements, Similarity2D
from fpnet_core.io.frozen import from_arrays, to_arrays
from fpnet_core.io.runs import read_output, write_output
from fpnet_core.matches import MatchHypothesis, MatchResult
from fpnet_core.pose_covariance import Growth, PoseCovariance, PoseFeatures
from fpnet_core.types import (
    GridMap,
    LocalizerOutput,
    PlanScale,
    Portal,
    Region,
    RegionGraph,
    RegionLabel,
    Segmentation,
    Status,
    Submap,
)

NUMBERS = st.floats(-50.0, 50.0, width=32)
POSES = st.builds(SE2.from_xy_yaw, NUMBERS, NUMBERS, NUMBERS)
SHARES = st.floats(0.01, 1.0)

GROWTH = Growth(0.05, 0.01, 0.003, 0.002)


def arrays(dtype, *shape):
    """Arrays of a shape, of values that survive in the type."""
    return st.integers(0, 2**32 - 1).map(
        lambda seed: np.random.default_rng(seed).integers(0, 2, shape).astype(dtype)
    )


@st.composite
def grids(draw, rows=4, columns=3):
    cells = draw(arrays(np.int8, rows, columns)) * draw(st.sampled_from([100, -1]))
    frame = draw(st.text('abc', min_size=1))
    return GridMap(cells, draw(st.floats(0.01, 1.0)), draw(POSES), frame)


# What needs more than its annotations tell: shapes, groups, what goes together.
SPECIAL = {
    SE2: POSES,
    Similarity2D: st.builds(
        lambda pose, scale: Similarity2D(pose.linear * scale, pose.translation),
        POSES, st.floats(0.5, 2.0),
    ),
    Affine2D: st.builds(
        lambda pose, shear: Affine2D(pose.linear @ [[1.0, shear], [0.0, 1.1]], pose.translation),
        POSES, st.floats(-0.5, 0.5),
    ),
    GridMap: grids(),
    Placements: st.integers(0, 3).flatmap(
        lambda count: st.builds(
            Placements, arrays(float, count, 2, 2), arrays(float, count, 2),
            st.just(np.full(count, np.nan)), arrays(float, count, 3, 3), arrays(float, count),
        )
    ),
}  # fmt: skip
SHAPES = {
    (Submap, 'lintel'): (bool, 4, 3), (Submap, 'path_xy'): (float, 2, 2),
    (Submap, 'recent_xy'): (float, 5, 2), (Submap, 'newest_xy'): (float, 0, 2),
    (Submap, 'newest_walls_xy'): (float, 0, 2),
    (Region, 'polygon'): (float, 4, 2), (Region, 'centroid'): (float, 2),
    (Portal, 'ends'): (float, 2, 2), (Segmentation, 'labels'): (np.int32, 4, 3),
    (RegionGraph, 'edges'): (np.int64, 3, 2), (RegionGraph, 'edge_feat'): (np.float32, 3, 6),
    (MatchHypothesis, 'pairs'): (np.int64, 2, 2), (MatchResult, 'pairs'): (np.int64, 1, 2),
    (MatchResult, 'scores'): (np.float32, 1), (MatchResult, 'probability'): (np.float32, 3, 2),
    (PlanScale, 'stretch'): (float, 2, 2), (PoseCovariance, 'cov'): (float, 3, 3),
    (PoseCovariance, 'xy_odom'): (float, 2), (PoseFeatures, 'information'): (float, 3, 3),
    (PoseFeatures, 'figures'): (float, 2),
}  # fmt: skip


def values(kind, owner=None, name=None):
    """Generate any value of an annotation; fails for what nobody said how to generate."""
    if (owner, name) in SHAPES:
        dtype, *shape = SHAPES[owner, name]
        return arrays(dtype, *shape)
    if kind in SPECIAL:
        return SPECIAL[kind]
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        return st.one_of(*(values(k, owner, name) for k in inner))
    if kind in COMPOSED:
        return COMPOSED[kind]()
    if is_dataclass(kind):
        return st.builds(kind, **members(kind))
    if isinstance(kind, type) and issubclass(kind, Enum):
        return st.sampled_from(list(kind))
    if origin is tuple:
        if inner[1:] == (Ellipsis,):
            return st.lists(values(inner[0]), max_size=2).map(tuple)
        return st.tuples(*map(values, inner))
    if origin is dict:
        return st.dictionaries(st.text(max_size=3), values(inner[1]), max_size=2)
    if origin is Literal:
        return st.sampled_from(inner)
    plain = {int: st.integers(0, 2**62), float: SHARES, str: st.text(), bool: st.booleans()}
    return {**plain, type(None): st.none()}[kind]


def members(kind):
    hints = get_type_hints(kind)
    return {f.name: values(hints[f.name], kind, f.name) for f in fields(kind)}


@st.composite
def regions_of(draw, labels):
    """Regions numbered from 0, with labels."""
    drawn = [draw(st.builds(Region, **members(Region))) for _ in labels]
    return tuple(
        replace(region, id=index, label=label)
        for index, (region, label) in enumerate(zip(drawn, labels, strict=True))
    )


ROOM_DOOR = (RegionLabel.ROOM, RegionLabel.ROOM, RegionLabel.DOOR)


@st.composite
def segmentations(draw):
    """Two rooms and a door; portals lead through the door, to a room or the unseen."""
    portal = st.builds(
        Portal, st.just(2), st.sampled_from([(0, 1), (0, None), (1, None)]),
        arrays(float, 2, 2), st.booleans(),
    )  # fmt: skip
    portals = tuple(draw(st.lists(portal, max_size=2)))
    labels = draw(arrays(np.int32, 4, 3))
    return Segmentation(
        draw(grids()), labels, draw(regions_of(ROOM_DOOR)), portals, draw(st.text())
    )


@st.composite
def region_graphs(draw):
    regions = draw(regions_of(ROOM_DOOR))
    node_feat = np.zeros((3, 28), np.float32)
    edges, edge_feat = np.zeros((0, 2), np.int64), np.zeros((0, 6), np.float32)
    return RegionGraph(
        regions, edges, node_feat, edge_feat, draw(st.sampled_from(['plan', 'submap']))
    )


@st.composite
def outputs(draw):
    """Ticks: a transform and LOCALIZED go together."""
    drawn = {name: draw(each) for name, each in members(LocalizerOutput).items()}
    drawn['status'] = Status.SEARCHING if drawn['A_plan_odom'] is None else Status.LOCALIZED
    return LocalizerOutput(**drawn)


COMPOSED = {Segmentation: segmentations, RegionGraph: region_graphs, LocalizerOutput: outputs}


def assert_equal(a, b):
    """Compare frozen values field by field, arrays element by element."""
    assert type(a) is type(b)
    if is_dataclass(a):
        for entry in fields(a):
            assert_equal(getattr(a, entry.name), getattr(b, entry.name))
    elif isinstance(a, np.ndarray):
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    elif isinstance(a, tuple):
        for x, y in zip(a, b, strict=True):
            assert_equal(x, y)
    else:
        assert a == b or a != a


@settings(max_examples=40, deadline=None)
@given(values(LocalizerOutput))
def test_every_field_of_every_type_comes_back(output):
    assert_equal(from_arrays(LocalizerOutput, to_arrays(output)), output)


def test_a_tick_survives_in_a_file(tmp_path):
    submap = Submap(GridMap(np.zeros((4, 3)), 0.1), np.zeros((4, 3)), np.zeros((2, 2)))
    output = LocalizerOutput(7, Status.SEARCHING, submap=submap, timings_ms={'total': 1.5})
    write_output(tmp_path / 'run' / 'last_tick.npz', output)
    assert_equal(read_output(tmp_path / 'run' / 'last_tick.npz'), output)
    assert [path.name for path in (tmp_path / 'run').iterdir()] == ['last_tick.npz']


def test_fields_that_a_file_lacks_take_their_defaults():
    stored = to_arrays(LocalizerOutput(7, Status.SEARCHING, reason='nothing seen'))
    tree = json.loads(str(stored['tree']))
    del tree['reason']
    assert (
        from_arrays(LocalizerOutput, {**stored, 'tree': np.array(json.dumps(tree))}).reason == ''
    )


def test_a_writer_that_fails_leaves_what_was_there(tmp_path, monkeypatch):
    path = tmp_path / 'tick.npz'
    write_output(path, LocalizerOutput(7, Status.SEARCHING))

    def full(*_, **__):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(np, 'savez_compressed', full)
    with pytest.raises(FpnetError, match=r'cannot write .*tick.npz: No space'):
        write_output(path, LocalizerOutput(8, Status.SEARCHING))
    monkeypatch.undo()
    assert read_output(path).stamp_ns == 7
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize('damage', ['absent', 'text', 'truncated', 'foreign', 'shape', 'field'])
def test_a_damaged_file_is_refused(tmp_path, damage):
    path = tmp_path / 'tick.npz'
    covariance = PoseCovariance(
        np.eye(3), np.zeros(2), 7, GROWTH, PoseFeatures(np.eye(3), np.zeros(2))
    )
    update = LocalizerOutput(7, Status.SEARCHING, covariance=covariance)
    if damage == 'text':
        path.write_text('no archive')
    elif damage == 'truncated':
        write_output(path, update)
        path.write_bytes(path.read_bytes()[:200])
    elif damage == 'foreign':
        np.savez(path, something=np.zeros(3))
    elif damage != 'absent':
        change = {'shape': ('[3, 3]', '[30, 3]'), 'field': ('"covariance"', '"__class__"')}[damage]
        stored = to_arrays(update)
        np.savez(path, **{**stored, 'tree': np.array(str(stored['tree']).replace(*change))})
    with pytest.raises(FpnetError, match='not a saved update'):
        read_output(path)
