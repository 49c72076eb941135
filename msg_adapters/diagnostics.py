# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the localizer claims, to and from ``diagnostic_msgs/DiagnosticStatus``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from fpnet_core.types import LocalizerOutput, Status

_OK, _WARN, _ERROR = b'\x00', b'\x01', b'\x02'
_LEVELS = {
    Status.NO_PLAN: _WARN,
    Status.WAITING: _OK,
    Status.SEARCHING: _OK,
    Status.AMBIGUOUS: _OK,
    Status.LOCALIZED: _OK,
    Status.LOST: _ERROR,
}
_MESSAGES = {
    Status.NO_PLAN: 'no floorplan received',
    Status.WAITING: 'too little explored',
    Status.SEARCHING: 'no placement fits well enough',
    Status.AMBIGUOUS: 'several placements fit',
    Status.LOCALIZED: 'localized',
    Status.LOST: 'no longer agrees with the floorplan',
}


@dataclass(frozen=True)
class LocalizerReport:
    """The status of one tick, and figures by name (milliseconds, counts)."""

    status: Status
    probability: float
    stamp_ns: int
    values: dict[str, float] = field(default_factory=dict)


def report_of_output(output: LocalizerOutput, dropped_scans: int = 0) -> LocalizerReport:
    """Return the report of a tick."""
    values = {f'{stage}_ms': ms for stage, ms in output.timings_ms.items()}
    values['dropped_scans'] = float(dropped_scans)
    if output.submap is not None:
        values['explored_m2'] = output.submap.free_area_m2
    if output.graph is not None:
        values['regions'] = float(len(output.graph))
    if output.match is not None:
        values['matches'] = float(len(output.match.pairs))
    return LocalizerReport(output.status, output.probability, output.stamp_ns, values)


def report_to_msg(report: LocalizerReport, name: str) -> Any:
    """Return a DiagnosticStatus; ``name`` is the node's."""
    from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

    entries = {
        'status': report.status.value,
        'probability': f'{report.probability:.4f}',
        'stamp_ns': str(report.stamp_ns),
        **{key: f'{value:.3f}' for key, value in report.values.items()},
    }
    return DiagnosticStatus(
        level=_LEVELS[report.status],
        name=name,
        message=_MESSAGES[report.status],
        values=[KeyValue(key=key, value=value) for key, value in entries.items()],
    )


def report_from_msg(msg: Any) -> LocalizerReport:
    """
    Return the report in a localizer's DiagnosticStatus.

    Raises
    ------
    ValueError
        If the message is not one of :func:`report_to_msg`.
    """
    entries = {entry.key: entry.value for entry in msg.values}
    try:
        return LocalizerReport(
            Status(entries.pop('status')),
            float(entries.pop('probability')),
            int(entries.pop('stamp_ns')),
            {key: float(value) for key, value in entries.items()},
        )
    except (KeyError, ValueError) as error:
        raise ValueError(f"{msg.name}: not a localizer's status: {error}") from None
