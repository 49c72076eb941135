# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

from dataclasses import replace

from diagnostic_msgs.msg import DiagnosticStatus
import numpy as np
import pytest

from fpnet_core.geometry import Affine2D
from fpnet_core.types import Cause, CauseKind, LocalizerOutput, Status
from msg_adapters.diagnostics import (
    diagnostics_to_msg,
    health_to_msg,
    report_from_msg,
    report_of_output,
    report_to_msg,
)


@pytest.mark.parametrize('status', [s for s in Status if s is not Status.LOCALIZED])
def test_every_status_survives_the_round_trip(received, status):
    output = LocalizerOutput(
        1_700_000_000_000_000_007,
        status,
        probability=0.8125,
        timings_ms={'total': 41.5},
        reason='explains 30 % of the observed walls: possibly another building',
        is_mirrored=status is Status.SEARCHING,
        causes=(Cause(CauseKind.SCALE, 'fits at 1.5 "times"', 'fpnet localize'),),
    )
    sent = report_of_output(output, {'dropped_scans': 3.0}, 'no cloud for 4 s')
    msg = received(report_to_msg(sent, '/localizer'))
    assert msg.name == '/localizer'
    report = report_from_msg(msg)
    assert report.status is status
    assert report.stamp_ns == output.stamp_ns
    assert report.probability == 0.8125
    assert report.reason == output.reason
    assert report.is_mirrored == output.is_mirrored
    assert report.warning == 'no cloud for 4 s'
    assert report.causes == output.causes
    assert report.values == {'total_ms': 41.5, 'hypotheses': 0.0, 'dropped_scans': 3.0}


@pytest.mark.parametrize(
    ('kind', 'is_said'),
    [(None, True), (CauseKind.TOO_LITTLE, True), (CauseKind.SELF_SIMILAR, True),
     (CauseKind.SCALE, False)],
)  # fmt: skip
def test_a_look_is_what_to_do_next_where_more_of_it_helps(kind, is_said):
    causes = () if kind is None else (Cause(kind, 'so', 'fpnet localize'),)
    output = LocalizerOutput(0, Status.AMBIGUOUS, causes=causes)
    report = replace(report_of_output(output), look='drive 3 m ahead')
    assert report_from_msg(report_to_msg(report, '')).look == 'drive 3 m ahead'
    assert report.next == ('drive 3 m ahead' if is_said else 'fpnet localize')


def test_only_trouble_raises_the_level():
    levels = {
        status: report_to_msg(report_of_output(LocalizerOutput(0, status, reason='so')), '').level
        for status in Status
        if status is not Status.LOCALIZED
    }
    assert levels[Status.LOST] == DiagnosticStatus.ERROR
    assert levels[Status.NO_PLAN] == DiagnosticStatus.WARN
    assert levels[Status.SEARCHING] == DiagnosticStatus.OK
    warned = report_of_output(LocalizerOutput(0, Status.SEARCHING), warning='no cloud for 4 s')
    assert report_to_msg(warned, '').level == DiagnosticStatus.WARN
    assert 'no cloud' in report_to_msg(warned, '').message
    lost = report_of_output(LocalizerOutput(0, Status.LOST), warning='no cloud for 4 s')
    assert report_to_msg(lost, '').level == DiagnosticStatus.ERROR


def test_a_mirrored_floorplan_is_a_warning_and_the_message_says_why():
    reason = 'the floorplan seems to be mirrored'
    output = LocalizerOutput(
        0, Status.SEARCHING, probability=0.25, reason=reason, is_mirrored=True
    )
    msg = report_to_msg(report_of_output(output, warning='no cloud for 4 s'), '')
    assert msg.level == DiagnosticStatus.WARN
    assert msg.message == f'searching (p 0.25): {reason}; no cloud for 4 s'
    calm = report_to_msg(report_of_output(LocalizerOutput(0, Status.WAITING, reason='so')), '')
    assert (calm.level, calm.message) == (DiagnosticStatus.OK, 'waiting (p 0.00): so')


def test_a_drawing_that_is_out_of_date_is_a_warning_beside_the_pose():
    output = LocalizerOutput(0, Status.SEARCHING, probability=0.5, reason='so')
    outdated = replace(report_of_output(output), outdated='6 m of wall is not drawn')
    msg = report_to_msg(outdated, '')
    assert msg.level == DiagnosticStatus.WARN
    assert msg.message == 'searching (p 0.50): so; 6 m of wall is not drawn'
    assert report_from_msg(msg).outdated == outdated.outdated
    assert not outdated.is_trouble


def test_health_is_a_warning_or_ok(received):
    calm, warned = health_to_msg('a', '', {'scans': 3.0}), health_to_msg('b', 'slow', {})
    array = received(diagnostics_to_msg([calm, warned], 7))
    assert [status.level for status in array.status] in ([b'\x00', b'\x01'], [0, 1])
    assert array.status[0].values[0].key == 'scans'
    assert array.header.stamp.nanosec == 7


def test_a_claim_carries_its_scale():
    linear = np.array([[0.0, -1.05], [1.05, 0.0]])
    output = LocalizerOutput(0, Status.LOCALIZED, Affine2D(linear, np.zeros(2)), np.eye(3))
    assert report_of_output(output).values['scale'] == pytest.approx(1.05)


def test_a_foreign_status_is_refused():
    with pytest.raises(ValueError, match='camera'):
        report_from_msg(DiagnosticStatus(name='camera'))
