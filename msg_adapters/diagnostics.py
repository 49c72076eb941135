# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Status and health of a node, to and from ``diagnostic_msgs``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
import json
from typing import Any

from fpnet_core.types import Cause, CauseKind, LocalizerOutput, Status, status_line
from msg_adapters.stamps import header_to_msg

OK, WARN, ERROR = b'\x00', b'\x01', b'\x02'
"""Levels of ``diagnostic_msgs/DiagnosticStatus``."""

_TRUE, _FALSE = 'true', 'false'
_LEVELS = {
    Status.NO_PLAN: WARN,
    Status.WAITING: OK,
    Status.SEARCHING: OK,
    Status.AMBIGUOUS: OK,
    Status.LOCALIZED: OK,
    Status.LOST: ERROR,
}
_NEXT = {
    Status.NO_PLAN: 'serve a floorplan: floorplan_server, or map_server',
    Status.WAITING: 'drive on, if scans arrive: see /diagnostics',
    Status.LOCALIZED: '',
}
_DRIVE_ON = 'drive on'
_MORE_VIEWS = (None, CauseKind.TOO_LITTLE, CauseKind.SELF_SIMILAR)
"""Causes that are resolved by looking elsewhere."""


@dataclass(frozen=True)
class LocalizerReport:
    """
    Status of one update with its reason, and values by name (milliseconds, seconds, counts).

    ``is_mirrored``: only the mirror image fits. ``warning`` is a problem beside the status, for
    example dropped scans; empty: none. ``causes`` are the likely causes of having no pose;
    ``outdated`` says where the drawing is out of date around a pose, and ``look`` where to look
    next without one.
    """

    status: Status
    probability: float
    stamp_ns: int
    values: dict[str, float] = field(default_factory=dict)
    reason: str = ''
    is_mirrored: bool = False
    warning: str = ''
    causes: tuple[Cause, ...] = ()
    outdated: str = ''
    look: str = ''

    @property
    def is_trouble(self) -> bool:
        """Return whether the status needs attention."""
        is_starved = self.status is Status.WAITING and bool(self.warning)
        return self.status is Status.LOST or self.is_mirrored or is_starved

    @property
    def next(self) -> str:
        """Advice on the likeliest cause of having no pose; empty with one."""
        if self.status is Status.LOCALIZED:
            return ''
        kind = self.causes[0].kind if self.causes else None
        if self.look and kind in _MORE_VIEWS:
            return self.look
        return self.causes[0].next if self.causes else _NEXT.get(self.status, _DRIVE_ON)

    @property
    def said(self) -> str:
        """Status, probability and reason in one line."""
        return status_line(self.status, self.probability, self.reason)


def report_of_output(
    output: LocalizerOutput, figures: Mapping[str, float] | None = None, warning: str = ''
) -> LocalizerReport:
    """Return the report of an update; ``figures`` are values that only the node knows."""
    values = {f'{stage}_ms': ms for stage, ms in output.timings_ms.items()}
    if output.A_plan_odom is not None:
        # Nominal metres of the drawing per true metre.
        values['scale'] = output.A_plan_odom.scale
    if output.submap is not None:
        values['explored_m2'] = output.submap.free_area_m2
    if output.graph is not None:
        values['regions'] = float(len(output.graph))
    if output.match is not None:
        values['matches'] = float(len(output.match.pairs))
    values['hypotheses'] = float(len(output.estimates))
    values |= figures or {}
    return LocalizerReport(
        output.status,
        output.probability,
        output.stamp_ns,
        values,
        output.reason,
        output.is_mirrored,
        warning,
        output.causes,
    )


def report_to_msg(report: LocalizerReport, name: str) -> Any:
    """Return a DiagnosticStatus; ``name`` is the name of the node."""
    entries = {
        'status': report.status.value,
        'probability': f'{report.probability:.4f}',
        'stamp_ns': str(report.stamp_ns),
        'reason': report.reason,
        'mirrored': _TRUE if report.is_mirrored else _FALSE,
        'warning': report.warning,
        'outdated': report.outdated,
        'look': report.look,
        'causes': json.dumps([cause.as_json() for cause in report.causes]),
    }
    level = _LEVELS[report.status]
    if report.warning or report.is_mirrored or report.outdated:
        level = max(level, WARN)
    message = '; '.join(filter(None, (report.said, report.outdated, report.warning)))
    return named_status_to_msg(level, name, message, {**entries, **_figures(report.values)})


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
            reason=entries.pop('reason'),
            is_mirrored=entries.pop('mirrored') == _TRUE,
            warning=entries.pop('warning'),
            outdated=entries.pop('outdated'),
            look=entries.pop('look'),
            causes=_causes_from_json(entries.pop('causes')),
            values={key: float(value) for key, value in entries.items()},
        )
    except (KeyError, ValueError) as error:
        raise ValueError(f"{msg.name}: not a localizer's status: {error}") from None


def _causes_from_json(text: str) -> tuple[Cause, ...]:
    try:
        return tuple(
            Cause(CauseKind(each['cause']), each['evidence'], each['next'])
            for each in json.loads(text)
        )
    except TypeError as error:
        raise ValueError(f'causes: {error}') from None


def health_to_msg(name: str, warning: str, values: Mapping[str, float]) -> Any:
    """Return the DiagnosticStatus of a node without a pose: OK unless there is a warning."""
    level = WARN if warning else OK
    return named_status_to_msg(level, name, warning or 'running', _figures(values))


def diagnostics_to_msg(statuses: list[Any], stamp_ns: int) -> Any:
    """Return a DiagnosticArray."""
    from diagnostic_msgs.msg import DiagnosticArray

    return DiagnosticArray(header=header_to_msg(stamp_ns, ''), status=statuses)


def _figures(values: Mapping[str, float]) -> dict[str, str]:
    return {key: f'{value:.3f}' for key, value in values.items()}


def named_status_to_msg(level: bytes, name: str, message: str, entries: Mapping[str, str]) -> Any:
    """Return a DiagnosticStatus with its entries."""
    from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

    return DiagnosticStatus(
        level=level,
        name=name,
        message=message,
        values=[KeyValue(key=key, value=value) for key, value in entries.items()],
    )
