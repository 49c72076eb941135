# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

from dataclasses import fields
import math

import numpy as np
import pytest

from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2, Affine2D, Placement, Placements
from fpnet_core.io.runs import read_output, write_output
from fpnet_core.types import (
    Cause,
    CauseKind,
    GridMap,
    LocalizerOutput,
    MatchResult,
    PlanScale,
    Portal,
    Region,
    RegionLabel,
    Segmentation,
    Status,
    Submap,
)


def _output() -> LocalizerOutput:
    rng = np.random.default_rng(11)
    cells = rng.choice(np.array([0, 100, -1], dtype=np.int8), size=(6, 9))
    grid = GridMap(cells, 0.05, SE2.from_xy_yaw(-1.0, 2.0, 0.3), 'submap')
    triangle = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]])
    square = np.array([[4.0, 0.0], [5.0, 0.0], [5.0, 1.0], [4.0, 1.0]])
    regions = (
        Region(0, RegionLabel.ROOM, triangle, triangle.mean(0), 6.0, 0.5, 0.25, 0.75),
        Region(1, RegionLabel.DOOR, square, square.mean(0), 1.0),
    )
    portals = (Portal(1, (0, None), np.array([[4.0, 0.2], [4.0, 1.1]]), True),)
    linear = np.array([[0.9, -0.35], [0.4, 1.1]])
    estimates = (
        Placement(Affine2D(linear, np.ones(2)), 0.8, np.eye(3), 0.97),
        Placement(SE2.from_xy_yaw(4.0, -2.0, 1.0), 0.5, np.diag([0.1, 0.2, 0.3]), 0.02),
    )
    return LocalizerOutput(
        stamp_ns=1_700_000_000_123_456_789,
        status=Status.LOCALIZED,
        A_plan_odom=Affine2D(linear, np.array([3.0, -7.0])),
        cov=np.diag([0.1, 0.2, 0.01]),
        probability=0.97,
        estimates=Placements.of(estimates),
        match=MatchResult(np.array([[5, 0]]), np.array([0.75]), np.full((7, 2), 0.1)),
        segmentation=Segmentation(grid, np.ones((6, 9)), regions, portals, 'why not'),
        submap=Submap(
            grid,
            rng.random((6, 9)) > 0.5,
            np.array([[0.0, 1.0], [2.0, 3.0]]),
            SE2.from_xy_yaw(0.5, -0.25, math.radians(200.0)),
            1_700_000_000_123_456_789,
            12,
        ),
        timings_ms={'total': 41.5, 'match': 7.25},
        scale=PlanScale(np.array([[1.1, 0.01], [0.01, 0.95]]), 0.02, True),
        reason='91 % of 140 m of wall explained; no rival was found',
        is_mirrored=True,
        causes=(Cause(CauseKind.DRIFT, 'walls turn', 'fpnet localize'),),
    )


def _assert_equal(a, b) -> None:
    """Compare frozen values field by field, arrays element by element."""
    assert type(a) is type(b)
    if hasattr(a, '__dataclass_fields__'):
        for entry in fields(a):
            _assert_equal(getattr(a, entry.name), getattr(b, entry.name))
    elif isinstance(a, np.ndarray):
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    elif isinstance(a, tuple):
        assert len(a) == len(b)
        for x, y in zip(a, b, strict=True):
            _assert_equal(x, y)
    else:
        assert a == b


def test_a_tick_survives_the_round_trip(tmp_path):
    path = tmp_path / 'run' / 'last_tick.npz'
    write_output(path, _output())
    _assert_equal(read_output(path), _output())


def test_a_tick_of_an_older_version_can_be_read(tmp_path):
    path = tmp_path / 'tick.npz'
    write_output(path, _output())
    with np.load(path) as file:
        newer = {'estimate_probability', 'why', 'is_mirrored', 'causes'}
        arrays = {name: file[name] for name in file if name not in newer}
    np.savez(path, **arrays)
    output = read_output(path)
    assert (output.reason, output.is_mirrored, output.causes) == ('', False, ())
    read, written = output.estimates, _output().estimates
    assert np.isnan(read.probability).all()
    np.testing.assert_array_equal(read.score, written.score)
    np.testing.assert_array_equal(read.matrix, written.matrix)


def test_an_empty_tick_survives_the_round_trip(tmp_path):
    output = LocalizerOutput(7, Status.NO_PLAN)
    write_output(tmp_path / 'tick.npz', output)
    _assert_equal(read_output(tmp_path / 'tick.npz'), output)


def test_a_segmentation_without_regions_survives(tmp_path):
    grid = GridMap(np.zeros((2, 3), dtype=np.int8), 0.1, frame='submap')
    empty = Segmentation(grid, np.zeros((2, 3)), (), (), 'nothing seen')
    output = LocalizerOutput(7, Status.SEARCHING, segmentation=empty)
    write_output(tmp_path / 'tick.npz', output)
    _assert_equal(read_output(tmp_path / 'tick.npz'), output)


@pytest.mark.parametrize('damage', ['absent', 'text', 'truncated', 'foreign'])
def test_a_damaged_file_is_refused(tmp_path, damage):
    path = tmp_path / 'tick.npz'
    if damage == 'text':
        path.write_text('no archive')
    elif damage == 'truncated':
        write_output(path, _output())
        path.write_bytes(path.read_bytes()[:400])
    elif damage == 'foreign':
        np.savez(path, something=np.zeros(3))
    with pytest.raises(FpnetError, match='not a written tick'):
        read_output(path)
