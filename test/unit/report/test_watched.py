# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A running localizer on a page: values as bytes and back, and what the page is told of them."""

from dataclasses import replace
import zlib

import numpy as np
import pytest

from fpnet.cli import main
from fpnet.report.record import RunRecord
from fpnet.report.watched import WatchedRun, with_update
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2
from fpnet_core.io.serialization import ShownPlan, ShownTick, packed, unpacked
from fpnet_core.localizer.kept import is_brief
from fpnet_core.trajectory import PlanarTrajectory


def update(run, index, number=1, poses=None):
    pose = SE2.from_xy_yaw(1.0, 2.0, 0.5)
    return ShownTick(number, run.outputs[index], pose, poses or PlanarTrajectory.empty())


def test_ticks_and_plans_come_back_as_they_were(made_up_run):
    sent = update(made_up_run, 2, poses=made_up_run.published)
    got = unpacked(ShownTick, packed(sent))
    assert got.number == 1
    assert got.output.said == sent.output.said
    np.testing.assert_array_equal(got.output.submap.grid.cells, sent.output.submap.grid.cells)
    np.testing.assert_array_equal(got.poses.stamps_ns, made_up_run.published.stamps_ns)
    assert got.T_odom_base.yaw == pytest.approx(0.5)
    plan = unpacked(ShownPlan, packed(ShownPlan(4, 'attic', made_up_run.plan)))
    assert (plan.number, plan.name) == (4, 'attic')
    assert len(plan.rooms.regions) == len(made_up_run.plan.regions)


def test_what_is_cut_off_or_of_another_kind_is_one_line(made_up_run):
    data = packed(update(made_up_run, 2))
    for broken in (b'', data[:-9], data[9:], zlib.compress(b'no archive'), data[:50] * 3):
        with pytest.raises(FpnetError, match='same version of fpnet'):
            unpacked(ShownTick, broken)
    with pytest.raises(FpnetError, match='does not describe a ShownPlan'):
        unpacked(ShownPlan, data)


def test_old_ticks_are_kept_small_and_poses_once(made_up_run):
    record = RunRecord('', '', made_up_run.plan)
    for index in range(3):
        record = with_update(record, update(made_up_run, index, poses=made_up_run.published))
    assert [output.status for output in record.outputs] == [
        output.status for output in made_up_run.outputs
    ]
    assert [is_brief(output) for output in record.outputs[1:]] == [True, False]
    assert len(record.published) == len(made_up_run.published)


class Page:
    """What a page would be told, in the place of the server."""

    def __init__(self, *_):
        self.told = []

    url = 'http://127.0.0.1:1/'

    def __getattr__(self, name):
        return lambda *values: self.told.append((name, *values))


@pytest.fixture
def page(monkeypatch):
    page = Page()
    monkeypatch.setattr('fpnet.report.watched.LiveRun', lambda *_: page)
    return page


def test_a_page_begins_with_the_plan_and_follows_the_node(made_up_run, page):
    said = []
    watched = WatchedRun(0, said.append)
    watched.take('no_plan')
    watched.take('no_plan')
    watched.take(update(made_up_run, 0))  # on a plan that nobody has seen yet
    watched.take(ShownPlan(1, 'low', made_up_run.plan))
    assert said == ['no_plan', f'watch it at {page.url}']
    watched.take(f'{made_up_run.outputs[1].said}; scans are dropped')
    watched.take(update(made_up_run, 1))
    watched.take(update(made_up_run, 2, number=2))
    assert [name for name, *_ in page.told] == ['say', 'show']
    _, record, words = page.told[-1]
    assert words.endswith('scans are dropped')
    assert len(record.outputs) == 1
    watched.take(ShownPlan(2, 'high', made_up_run.plan))
    watched.take(update(made_up_run, 2, number=2))
    assert page.told[-2][:2] == ('begin', 'live on high')
    assert len(page.told[-1][1].outputs) == 1


def test_a_clock_that_goes_back_begins_anew(made_up_run, page):
    watched = WatchedRun(0, lambda _: None)
    watched.take(ShownPlan(1, '', made_up_run.plan))
    for index in (1, 2, 0):
        watched.take(update(made_up_run, index))
    assert [name for name, *_ in page.told] == ['show', 'show', 'begin', 'show']
    assert len(page.told[-1][1].outputs) == 1


def test_poses_that_come_again_are_left_out(made_up_run):
    poses = made_up_run.published
    one = PlanarTrajectory(poses.stamps_ns[:1], poses.xy[:1], poses.yaw[:1])
    record = replace(made_up_run, published=one)
    joined = with_update(record, update(made_up_run, 2, poses=poses)).published
    np.testing.assert_array_equal(joined.stamps_ns, poses.stamps_ns)


@pytest.mark.parametrize('words', [[], ['drive.bag', '--nodes']])
def test_a_recording_or_the_nodes_must_be_named(words, capsys):
    with pytest.raises(SystemExit) as ended:
        main(['view', *words])
    assert ended.value.code == 1
    assert 'give a recording' in capsys.readouterr().err
