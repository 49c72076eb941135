# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the nodes share, without a middleware running."""

import os
from pathlib import Path
import re
import signal
import subprocess
import sys
from threading import Event, Thread
import time
from types import SimpleNamespace
from typing import Literal

from pydantic import Field
import pytest
from rcl_interfaces.msg import ParameterType

from fpnet_core.config import Section
from fpnet_core.config_docs import config_fields
from fpnet_core.errors import CloudFormatError, ConfigError, FpnetError, OdometryError
from fpnet_core.types import Status
from fpnet_lab.nodes import processes
from fpnet_lab.nodes.processes import NodeDiedError, ProcessGroup, ros_arguments
from fpnet_ros.logs import NodeLog
from fpnet_ros.params import describe, raise_unknown
from fpnet_ros.robot_odometry import OdometryRun
from fpnet_ros.settings import known_parameters
from fpnet_ros.state_file import StateFile
from fpnet_ros.sweeps import Numbering
from fpnet_ros.work import DroppingWorker, Worker
from msg_adapters.diagnostics import LocalizerReport

SLEEP = [sys.executable, '-c', 'import time; time.sleep(600)']


def _is_running(pid: int) -> bool:
    try:
        state = Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()[0]
    except FileNotFoundError:
        return False
    return state != 'Z'


def _wait_until_ended(pid: int, timeout_s: float = 10.0) -> bool:
    deadline = time.monotonic() + timeout_s
    while _is_running(pid) and time.monotonic() < deadline:
        time.sleep(0.02)
    return not _is_running(pid)


class TestErrorLog:
    def test_one_line_per_kind_and_period_with_a_count_of_the_rest(self):
        lines, now = [], [100.0]
        log = NodeLog(SimpleNamespace(error=lines.append), clock=lambda: now[0])
        log.report(CloudFormatError('bad\n  cloud 1'))
        log.report(CloudFormatError('bad cloud 2'))
        log.report(CloudFormatError('other cloud 3'))
        log.report(OdometryError('bad pose at -1.5 m'))
        now[0] += 4.9
        log.report(CloudFormatError('bad cloud 4'))
        now[0] += 0.2
        log.report(CloudFormatError('bad cloud 17'))
        log.report(OdometryError('bad pose at -23.5 m'))
        assert lines == [
            'bad cloud 1',
            'other cloud 3',
            'bad pose at -1.5 m',
            'bad cloud 17 (2 more since the last report)',
            'bad pose at -23.5 m',
        ]


class TestLossLog:
    def test_a_loss_is_logged_with_its_remedy_once_until_it_was_quiet_for_long(self):
        lines, now = [], [100.0]
        log = NodeLog(SimpleNamespace(warning=lines.append), clock=lambda: now[0])
        for count, seconds in ((0, 1.0), (3, 1.0), (5, 50.0), (6, 50.0), (6, 60.0), (7, 1.0)):
            now[0] += seconds
            news = log.losses({'slow': count, 'other': count}, {'slow': 'send fewer'})
        assert news == ['slow', 'other']
        assert lines == ['slow; send fewer', 'slow; send fewer'], 'the other is logged elsewhere'
        assert log.losses({'slow': 7, 'other': 7}, {}) == []


class TestSilenceLog:
    def test_a_topic_is_missed_once_and_again_after_it_was_heard(self):
        told, warned = [], []
        log = NodeLog(SimpleNamespace(info=told.append, warning=warned.append))
        for age_s in (0.5, 3.5, 4.5, 0.1, 0.2, 9.0):
            log.silences({'/scan': age_s, '/odom': 0.1}, 3.0)
        assert warned == [
            'no message on /scan for 4 s: is it published?',
            'no message on /scan for 9 s: is it published?',
        ]
        assert told == ['/scan is received again']


@pytest.mark.parametrize(
    ('name', 'message'),
    [
        ('transform_tolernce', 'unknown; did you mean transform_tolerance?'),
        ('zzz', 'zzz is unknown; docs/ros.md lists all parameters'),
    ],
)
def test_an_unknown_parameter_is_refused_with_the_nearest_known_one(name, message):
    with pytest.raises(ConfigError, match=re.escape(message)):
        raise_unknown([name], known_parameters())


class TestStatusLog:
    def test_each_change_is_told_once_and_trouble_as_a_warning(self):
        told, warned = [], []
        log = NodeLog(SimpleNamespace(info=told.append, warning=warned.append))
        for status, is_mirrored in (
            (Status.SEARCHING, False),
            (Status.SEARCHING, False),
            (Status.SEARCHING, True),
            (Status.LOCALIZED, False),
            (Status.LOCALIZED, False),
            (Status.LOST, False),
            (Status.SEARCHING, False),
        ):
            reason = 'mirrored' if is_mirrored else status.value.upper()
            log.status(LocalizerReport(status, 0.5, 0, {}, reason, is_mirrored))
        assert told == [
            'searching (p 0.50): SEARCHING',
            'localized (p 0.50): LOCALIZED',
            'searching (p 0.50): SEARCHING',
        ]
        assert warned == ['searching (p 0.50): mirrored', 'lost (p 0.50): LOST']


class TestDroppingWorker:
    def test_the_oldest_are_dropped_and_the_order_is_kept(self):
        busy, done = Event(), []

        def work(item):
            busy.wait(20)
            done.append(item)

        worker = DroppingWorker(work, 3, done.append)
        worker.put(0)
        deadline = time.monotonic() + 20
        while worker._waiting and time.monotonic() < deadline:
            time.sleep(0.01)
        for item in range(1, 8):
            worker.put(item)
        assert worker.dropped == 4
        busy.set()
        while worker.done < 4 and time.monotonic() < deadline:
            time.sleep(0.01)
        worker.close()
        assert done == [0, 5, 6, 7]

    def test_an_error_is_handed_on_and_work_goes_on(self):
        errors, finished = [], Event()

        def work(item):
            if item == 'bad':
                raise CloudFormatError('bad scan')
            finished.set()

        worker = DroppingWorker(work, 3, errors.append)
        worker.put('bad')
        worker.put('good')
        assert finished.wait(20)
        worker.close()
        assert [str(error) for error in errors] == ['bad scan']
        assert (worker.done, worker.refused) == (1, 1), 'what was refused is not done'


class TestWorker:
    def test_work_is_done_in_order_and_an_error_ends_nothing(self):
        errors, done = [], []

        def fail():
            raise CloudFormatError('bad scan')

        worker = Worker('test', errors.append)
        worker.submit(done.append, 1)
        failed = worker.submit(fail)
        last = worker.submit(lambda: done.append(2) or 'result')
        assert (last.result(20), done) == ('result', [1, 2])
        assert [str(error) for error in errors] == ['bad scan']
        assert isinstance(failed.exception(), CloudFormatError)
        worker.close()

    def test_what_waits_at_the_end_is_dropped(self):
        errors, begun, busy = [], Event(), Event()
        worker = Worker('test', errors.append)
        worker.submit(lambda: begun.set() or busy.wait(20))
        waiting = worker.submit(errors.append, 'worked')
        assert begun.wait(20)
        closing = Thread(target=worker.close)
        closing.start()
        deadline = time.monotonic() + 20
        while not waiting.cancelled() and time.monotonic() < deadline:
            time.sleep(0.01)
        busy.set()
        closing.join(20)
        assert waiting.cancelled()
        assert errors == []


class TestNumbering:
    @staticmethod
    def _info(number: int) -> dict[str, int]:
        return {'publication_sequence_number': number}

    def test_gaps_are_counted_and_a_new_publisher_is_noticed(self):
        numbering = Numbering()
        follow = lambda number: numbering.follow(self._info(number))  # noqa: E731
        assert not any(map(follow, (7, 8, 11, 12)))
        assert (numbering.lost, numbering.earlier) == (2, 6)
        assert follow(1)
        assert not follow(2)
        assert numbering.lost == 2

    def test_publishers_that_take_turns_lose_nothing(self):
        numbering = Numbering()
        for number in (50_000, 3, 50_001, 4):
            numbering.follow(self._info(number))
        assert numbering.lost == 0

    def test_a_middleware_that_does_not_count_says_nothing(self):
        numbering = Numbering()
        for info in ({}, self._info(2**64 - 1), {}):
            assert not numbering.follow(info)
        assert numbering.lost == 0


class TestDescriptors:
    class Keys(Section):
        open_ends: float = Field(0.5, gt=0.0, lt=1.0, description='Between.')
        least: int = Field(3, ge=1, description='At least.')
        above: int = Field(3, gt=1, description='More than.')
        free: float = Field(0.0, description='Anything.')
        mode: Literal['slow', 'fast'] = Field('slow', description='How.')
        names: tuple[str, ...] = Field((), description='Which.')

    def test_ranges_types_and_texts_come_from_the_tree(self):
        d = {field.key: describe(field) for field in config_fields(self.Keys)}
        (interval,) = d['open_ends'].floating_point_range
        assert 0.0 < interval.from_value < 1e-300
        assert 1.0 - 1e-15 < interval.to_value < 1.0
        assert d['least'].integer_range[0].from_value == 1
        assert d['above'].integer_range[0].from_value == 2
        assert d['least'].integer_range[0].to_value == 2**63 - 1
        assert not d['free'].floating_point_range
        assert d['mode'].type == ParameterType.PARAMETER_STRING
        assert d['mode'].additional_constraints == 'one of slow, fast'
        assert d['names'].type == ParameterType.PARAMETER_STRING_ARRAY
        assert d['names'].description == 'Which.'
        assert not any(descriptor.read_only for descriptor in d.values())


class TestProcesses:
    def test_ros_arguments_keep_types_apart(self):
        arguments = ros_arguments({'a': '1', 'b': 1.0, 'c': True, 'd': ['/x']}, {'from': 'to'})
        assert arguments == [
            '--ros-args',
            *('-p', 'a:="1"', '-p', 'b:=1.0', '-p', 'c:=true', '-p', 'd:=["/x"]'),
            *('-r', 'from:=to'),
        ]

    def test_a_child_that_dies_is_named_with_its_last_words(self, tmp_path):
        with ProcessGroup(tmp_path, os.environ) as group:
            sleeper = group.start('sleeper', SLEEP)
            dying = group.start(
                'dying', [sys.executable, '-c', 'import sys; print("last words"); sys.exit(3)']
            )
            dying.process.wait(timeout=20)
            with pytest.raises(NodeDiedError, match=r'dying ended with status 3(.|\n)*last words'):
                group.check()
        assert _wait_until_ended(sleeper.process.pid)

    def test_a_child_may_end_well_only_where_that_is_expected(self, tmp_path):
        with ProcessGroup(tmp_path, os.environ) as group:
            done = group.start('done', [sys.executable, '-c', 'pass'])
            done.process.wait(timeout=20)
            group.check(may_end=[done])
            with pytest.raises(NodeDiedError, match='done ended with status 0'):
                group.check()

    def test_stubborn_children_are_killed(self, tmp_path, monkeypatch):
        monkeypatch.setattr(processes, '_GRACE_S', 0.5)
        script = (
            'import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN);'
            'print("deaf", flush=True); time.sleep(600)'
        )
        with ProcessGroup(tmp_path, os.environ) as group:
            child = group.start('stubborn', [sys.executable, '-c', script])
            deadline = time.monotonic() + 20
            while 'deaf' not in child.log_tail() and time.monotonic() < deadline:
                time.sleep(0.02)
        assert child.process.returncode == -signal.SIGKILL

    def test_children_end_where_the_parent_is_killed(self, tmp_path):
        script = (
            'import os, sys, time; from pathlib import Path;'
            'from fpnet_lab.nodes.processes import ProcessGroup;'
            f'group = ProcessGroup(Path({str(tmp_path)!r}), os.environ);'
            f'print(group.start("child", {SLEEP!r}).process.pid, flush=True); time.sleep(600)'
        )
        root = Path(processes.__file__).parents[2]
        with subprocess.Popen(
            [sys.executable, '-c', script], stdout=subprocess.PIPE, text=True, cwd=root
        ) as parent:
            child_pid = int(parent.stdout.readline())
            assert _is_running(child_pid)
            parent.kill()
        assert _wait_until_ended(child_pid)

    def test_a_missing_share_file_is_named(self):
        with pytest.raises(FpnetError, match=r'config/absent\.xml'):
            processes.share_file('config/absent.xml')

    def test_the_domain_is_one_that_nobody_uses(self):
        assert 1 <= processes.free_domain_id() <= 100


def test_without_a_place_for_the_state_nothing_is_saved_and_nothing_told():
    class Never:
        """Whatever is asked of it is one thing too many."""

        def __getattr__(self, name: str):
            if name != 'error':
                raise AssertionError(name)
            return self

    file = StateFile('', Never(), OdometryRun, Never())
    file.restore()
    assert file.save() == ''
