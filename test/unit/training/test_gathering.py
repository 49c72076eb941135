# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What fits and benchmarks keep comes back from its files, whatever it holds."""

from dataclasses import fields

import numpy as np
import pytest

from fpnet_core.scoring import CONTEXT, FIGURES, Evidence
from fpnet_core.segmentation.joining import DividingLines, Pieces
from fpnet_lab.evaluation.localization.records import Record
from fpnet_lab.evaluation.localization.suite import CaseOutcome
from fpnet_lab.kept import make_once
from fpnet_lab.training.covariance_drives import Samples
from fpnet_lab.training.door_samples import DoorSample
from fpnet_lab.training.doubts import DoubtTrial
from fpnet_lab.training.gathering import MapTask
from fpnet_lab.training.scale_samples import ScaleSamples
from fpnet_lab.training.scorer_trials import Trial, Trials

RNG = np.random.default_rng(8)
RECORD = Record(
    'bays-3', 'exact', 'bays', 'planar', 3, 'fpnet', '', False, True, False, 5, 0, 1.5, None, None,
    ((0.99, True), (0.4, False)), (12.5, float('nan')), None, 310.25, ('searching', 'localized'),
)  # fmt: skip
KEPT = [
    (
        tuple[DoorSample, ...],
        (
            DoorSample(
                'office_ä',
                'drawing',
                True,
                Pieces(RNG.random((3, 6)), RNG.random(3), RNG.random(3)),
                DividingLines(np.array([[1, 2]]), RNG.random(1), RNG.random((1, 4))),
                RNG.random((3, 2)),
            ),
        ),
    ),
    (tuple[DoorSample, ...], ()),
    (
        ScaleSamples,
        ScaleSamples(
            RNG.random((2, 5)), RNG.random(2), RNG.random(2), np.array(['plan', 'map']),
            np.array(['office_ä', 'b']), np.array([True, False]), np.array([False, True]),
        ),
    ),
    (
        Samples,
        Samples(
            RNG.random((2, 3)), RNG.random((2, 3, 3)), RNG.random((2, 2)), RNG.random(2),
            RNG.random((2, 3)), np.array([0, 4]), np.array([7, 7]),
        ),
    ),
    (
        Trials,
        tuple(
            Trial(
                Evidence(
                    RNG.random((count, len(FIGURES))).astype(np.float32),
                    RNG.random(len(CONTEXT)).astype(np.float32),
                ),
                RNG.random(count) < 0.5,
                count == 1,
                'real',
                'lab_a',
                kept,
            )
            for count, kept in ((1, float('nan')), (0, 0.3))
        ),
    ),
    (
        tuple[DoubtTrial, ...],
        (
            DoubtTrial(
                'scan', 4001, 0.9, RNG.random((2, 3)), np.array([True, False]), RNG.random(4)
            ),
        ),
    ),
    (CaseOutcome, CaseOutcome((RECORD,), '')),
]  # fmt: skip


def assert_same(a, b):
    """Compare values field by field, with the types of their elements."""
    assert type(a) is type(b)
    if isinstance(a, tuple):
        for one, other in zip(a, b, strict=True):
            assert_same(one, other)
    elif isinstance(a, np.ndarray):
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    elif hasattr(a, '__dataclass_fields__'):
        for each in fields(a):
            assert_same(getattr(a, each.name), getattr(b, each.name))
    else:
        np.testing.assert_equal(a, b)


@pytest.mark.parametrize(('kind', 'value'), KEPT, ids=lambda v: getattr(v, '__name__', ''))
def test_what_is_kept_comes_back_as_it_was(tmp_path, kind, value):
    def make(_):
        return value

    def fail(_):
        raise AssertionError('made again')

    make_once(tmp_path, kind, {'one': 0}, make)
    [back] = make_once(tmp_path, kind, {'one': 0}, fail)
    assert_same(back, value)


def test_a_map_follows_from_its_seed_and_has_a_name_of_its_own():
    tasks = [
        MapTask(np.random.Generator.random, 'a', 'plan', True, (seed, 3, 1)) for seed in (0, 1)
    ]
    assert [task.name for task in tasks] == ['0-3-1', '1-3-1']
    first, rng = tasks[0].begun()
    again, _ = tasks[0].begun()
    assert first == again == np.random.default_rng([0, 3, 1]).random()
    assert rng.random() != first
    assert tasks[1].begun()[0] != first
