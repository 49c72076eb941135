# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Exceptions at every step of the lifecycle: logged once, and the node ends in the right state."""

from threading import Event

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
import pytest
import rclpy
from rclpy.lifecycle import TransitionCallbackReturn
from std_msgs.msg import String

from fpnet_core.errors import MapFormatError
from fpnet_lab.nodes.processes import free_domain_id
from fpnet_ros.lifecycle import ManagedNode, spin
from fpnet_ros.logs import described

pytestmark = pytest.mark.ros

SUCCESS, ERROR = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.ERROR
STEPS = ('configure', 'activate', 'deactivate', 'cleanup')


class _Node(ManagedNode):
    """Raises at one step, the first time it comes there."""

    def __init__(self, fails_at: str = '', error: Exception | None = None) -> None:
        super().__init__('shaky')
        self.fails_at, self.error = fails_at, error
        self.given_up = 0

    def _step(self, name: str) -> None:
        if name == self.fails_at:
            self.fails_at = ''
            raise self.error

    def configure(self) -> None:
        self.publisher = self.add_publisher(String, 'words', 1)
        self.add_timer(10.0, lambda: None)
        self._step('configure')

    def activate(self) -> None:
        self._step('activate')

    def deactivate(self) -> None:
        self._step('deactivate')

    def cleanup(self) -> None:
        self.given_up += 1
        self._step('cleanup')

    @property
    def state(self) -> str:
        return self._state_machine.current_state[1]

    def ask(self, transition: int) -> bool:
        request = ChangeState.Request(transition=Transition(id=transition))
        return self._on_change_state(request, ChangeState.Response()).success

    def go(self) -> list[str]:
        """Try every step in order; return the state after each."""
        ids = (
            Transition.TRANSITION_CONFIGURE,
            Transition.TRANSITION_ACTIVATE,
            Transition.TRANSITION_DEACTIVATE,
            Transition.TRANSITION_CLEANUP,
        )
        states = []
        for each in ids:
            self.ask(each)
            states.append(self.state)
        return states


@pytest.fixture(scope='module', autouse=True)
def _ros():
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        rclpy.init(args=['--ros-args', '-p', 'autostart:=false'], domain_id=free_domain_id())
        yield
        rclpy.shutdown()


@pytest.fixture
def make():
    made = []

    def make(*arguments):
        made.append(_Node(*arguments))
        return made[-1]

    yield make
    for node in made:
        node.destroy_node()


def told(capfd) -> list[str]:
    """Return the lines that were logged as an error."""
    return [line for line in capfd.readouterr().err.splitlines() if '[ERROR]' in line]


# After a defect the node is unconfigured, whatever state it was in, and can be used again.
@pytest.mark.parametrize(
    ('step', 'states'),
    [
        ('configure', []),
        ('activate', ['inactive']),
        ('deactivate', ['inactive', 'active']),
        ('cleanup', ['inactive', 'active', 'inactive']),
    ],
)
def test_a_defect_at_any_step_is_told_once_and_unconfigures_the_node(make, capfd, step, states):
    node = make(step, KeyError('planted'))
    assert node.go() == states + ['unconfigured'] * (4 - len(states))
    (line,) = told(capfd)
    assert f'{step} failed: internal error, please report it: KeyError' in line
    assert 'test_ros_lifecycle.py' in line
    assert node.count_publishers('words') == 0
    assert not node.is_active
    assert [node.ask(Transition.TRANSITION_CONFIGURE), node.ask(Transition.TRANSITION_ACTIVATE)]
    assert node.state == 'active'


@pytest.mark.parametrize(
    ('step', 'state'),
    [('configure', 'unconfigured'), ('activate', 'inactive'), ('deactivate', 'active')],
)
def test_bad_input_at_a_step_leaves_the_node_where_it_was(make, capfd, step, state):
    node = make(step, MapFormatError('no room in it'))
    assert state in node.go()
    (line,) = told(capfd)
    assert line.endswith(f'{step} failed: no room in it')


def test_after_bad_input_while_deactivating_the_node_goes_on_working(make):
    node = make('deactivate', MapFormatError('no room in it'))
    for transition in (1, 3, 4):
        node.ask(transition)
    assert node.state == 'active'
    assert node.is_active
    assert node.publisher.is_activated


def test_a_defect_in_shutdown_is_told_and_ends_finalized(make, capfd):
    node = make('cleanup', ValueError('planted'))
    assert node.ask(Transition.TRANSITION_CONFIGURE)
    node.ask(Transition.TRANSITION_INACTIVE_SHUTDOWN)
    assert node.state == 'finalized'
    (line,) = told(capfd)
    assert 'shutdown failed: internal error, please report it: ValueError: planted' in line


def test_a_defect_in_giving_up_after_a_defect_ends_finalized(make, capfd):
    node = make('activate', ValueError('first'))
    assert node.ask(Transition.TRANSITION_CONFIGURE)

    def again() -> None:
        raise ValueError('second')

    node._undo.callback(again)
    assert not node.ask(Transition.TRANSITION_ACTIVATE)
    assert node.state == 'finalized'
    first, second = told(capfd)
    assert 'activate failed' in first
    assert 'error failed' in second
    assert node.given_up == 1, 'what follows is given up all the same'


def test_a_request_that_does_not_fit_the_state_is_refused_and_ends_nothing(make, capfd):
    node = make()
    assert not node.ask(Transition.TRANSITION_ACTIVATE)
    assert node.state == 'unconfigured'
    assert 'no transition 3 from state unconfigured; ignored' in capfd.readouterr().err
    assert node.ask(Transition.TRANSITION_CONFIGURE)


def test_the_cause_of_a_defect_is_told():
    try:
        try:
            raise OSError('no such device')
        except OSError as error:
            raise RuntimeError('sensor\nis gone') from error
    except RuntimeError as error:
        said = described(error)
    assert said.startswith('internal error, please report it: RuntimeError: sensor is gone in ')
    assert said.endswith('caused by: OSError: no such device')


class _Slow(ManagedNode):
    """Takes as long to prepare as until it has answered somebody."""

    def __init__(self) -> None:
        super().__init__('slow')
        self.answered, self.fails, self.has_prepared = Event(), False, []
        self.create_timer(0.01, self.answered.set)

    def prepare(self) -> None:
        self.has_prepared.append(self.answered.wait(30.0))
        if self.fails:
            raise MapFormatError('not yet')

    def start(self) -> None:
        raise EOFError


def test_a_node_answers_while_it_prepares():
    node = _Slow()
    try:
        with pytest.raises(EOFError):
            spin(node)
        assert node.has_prepared == [True]
        assert node.trigger_configure() == SUCCESS
        assert node.has_prepared == [True]  # once for all times
    finally:
        node.destroy_node()


def test_who_could_not_prepare_tries_again_when_configured(capfd):
    node = _Slow()
    try:
        node.answered.set()
        node.fails = True
        assert node.trigger_configure() != SUCCESS
        assert len(told(capfd)) == 1
        node.fails = False
        assert node.trigger_configure() == SUCCESS
        assert len(node.has_prepared) == 2
    finally:
        node.destroy_node()
