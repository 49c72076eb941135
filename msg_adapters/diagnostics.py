# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a node claims and how it fares, to and from ``diagnostic_msgs``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fpnet_core.types import LocalizerOutput, Status
from msg_adapters.stamps import header_to_msg

OK, WARN, ERROR = b'\x00', b'\x01', b'\x02'
"""Levels of ``diagnostic_msgs/DiagnosticStatus``."""

_LEVELS = {
    Status.NO_PLAN: WARN,
    Status.WAITING: OK,
    Status.SEARCHING: OK,
    Status.AMBIGUOUS: OK,
    Status.LOCALIZED: OK,
    Status.LOST: ERROR,
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
    """
    The status of one tick, and figures by name (milliseconds, seconds, counts).

    ``warning`` says what is wrong beside the status, as scans that are dropped; empty: nothing.
    """

    status: Status
    probability: float
    stamp_ns: int
    values: dict[str, float] = field(default_factory=dict)
    warning: str = ''


def report_of_output(
    output: LocalizerOutput, figures: Mapping[str, float] | None = None, warning: str = ''
) -> LocalizerReport:
    """
    Return the report of a tick; ``figures`` are those that only the node knows.

    The tick's own reason comes first among the warnings.
    """
    values = {f'{stage}_ms': ms for stage, ms in output.timings_ms.items()}
    if output.A_plan_odom is not None:
        # Nominal metres of the drawing per true metre.
        values['scale'] = float(np.sqrt(abs(np.linalg.det(output.A_plan_odom.linear))))
    if output.submap is not None:
        values['explored_m2'] = output.submap.free_area_m2
    if output.graph is not None:
        values['regions'] = float(len(output.graph))
    if output.match is not None:
        values['matches'] = float(len(output.match.pairs))
    values['hypotheses'] = float(len(output.estimates))
    values |= figures or {}
    warning = ', '.join(filter(None, (output.reason, warning)))
    return LocalizerReport(output.status, output.probability, output.stamp_ns, values, warning)


def report_to_msg(report: LocalizerReport, name: str) -> Any:
    """Return a DiagnosticStatus; ``name`` is the node's."""
    entries = {
        'status': report.status.value,
        'probability': f'{report.probability:.4f}',
        'stamp_ns': str(report.stamp_ns),
        'warning': report.warning,
    }
    level, message = _LEVELS[report.status], _MESSAGES[report.status]
    if report.warning:
        level, message = max(level, WARN), f'{message}; {report.warning}'
    return _status_msg(level, name, message, {**entries, **_figures(report.values)})


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
            warning=entries.pop('warning'),
            values={key: float(value) for key, value in entries.items()},
        )
    except (KeyError, ValueError) as error:
        raise ValueError(f"{msg.name}: not a localizer's status: {error}") from None


def health_to_msg(name: str, warning: str, values: Mapping[str, float]) -> Any:
    """Return the DiagnosticStatus of a node that claims nothing: OK unless there is a warning."""
    level = WARN if warning else OK
    return _status_msg(level, name, warning or 'running', _figures(values))


def diagnostics_to_msg(statuses: list[Any], stamp_ns: int) -> Any:
    """Return a DiagnosticArray."""
    from diagnostic_msgs.msg import DiagnosticArray

    return DiagnosticArray(header=header_to_msg(stamp_ns, ''), status=statuses)


def _figures(values: Mapping[str, float]) -> dict[str, str]:
    return {key: f'{value:.3f}' for key, value in values.items()}


def _status_msg(level: bytes, name: str, message: str, entries: Mapping[str, str]) -> Any:
    from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

    return DiagnosticStatus(
        level=level,
        name=name,
        message=message,
        values=[KeyValue(key=key, value=value) for key, value in entries.items()],
    )
