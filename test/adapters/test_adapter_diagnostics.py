# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

from diagnostic_msgs.msg import DiagnosticStatus
import pytest

from fpnet_core.types import LocalizerOutput, Status
from msg_adapters.diagnostics import report_from_msg, report_of_output, report_to_msg


@pytest.mark.parametrize('status', [s for s in Status if s is not Status.LOCALIZED])
def test_every_status_survives_the_round_trip(received, status):
    output = LocalizerOutput(
        1_700_000_000_000_000_007, status, probability=0.8125, timings_ms={'total': 41.5}
    )
    msg = received(report_to_msg(report_of_output(output, dropped_scans=3), '/localizer'))
    assert msg.name == '/localizer'
    report = report_from_msg(msg)
    assert report.status is status
    assert report.stamp_ns == output.stamp_ns
    assert report.probability == 0.8125
    assert report.values == {'total_ms': 41.5, 'dropped_scans': 3.0}


def test_only_trouble_raises_the_level():
    levels = {
        status: report_to_msg(report_of_output(LocalizerOutput(0, status)), '').level
        for status in Status
        if status is not Status.LOCALIZED
    }
    assert levels[Status.LOST] == DiagnosticStatus.ERROR
    assert levels[Status.NO_PLAN] == DiagnosticStatus.WARN
    assert levels[Status.SEARCHING] == DiagnosticStatus.OK


def test_a_foreign_status_is_refused():
    with pytest.raises(ValueError, match='camera'):
        report_from_msg(DiagnosticStatus(name='camera'))
