# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How a localizer node fares beside what it says of the robot: its inputs and its scans."""

from __future__ import annotations

from typing import Any

from fpnet_core.types import LocalizerOutput
from fpnet_ros.inputs import ScanInput
from fpnet_ros.work import DroppingWorker
from msg_adapters.diagnostics import LocalizerReport, report_of_output


class Health:
    """Puts figures and warnings of one node beside its outputs."""

    def __init__(self, inputs: ScanInput, scans: DroppingWorker[Any]) -> None:
        self._inputs = inputs
        self._scans = scans
        self._reported_drops = self._reported_losses = 0

    def report(self, output: LocalizerOutput, stale_input_s: float) -> LocalizerReport:
        """Return what a tick says; inputs that were silent for longer are a warning."""
        return self._report(output, self._silences(stale_input_s))

    def news(self, output: LocalizerOutput, stale_input_s: float) -> LocalizerReport:
        """Return the same with a warning of what was lost since the last call."""
        return self._report(output, [*self._losses(), *self._silences(stale_input_s)])

    def _report(self, output: LocalizerOutput, warnings: list[str]) -> LocalizerReport:
        figures = {
            **self._inputs.ages_s,
            'scan_ms': self._scans.work_ms,
            'scans': float(self._scans.done),
            'dropped_scans': float(self._dropped()),
            'lost_scans': float(self._inputs.lost),
        }
        return report_of_output(output, figures, ', '.join(warnings))

    def _silences(self, stale_input_s: float) -> list[str]:
        return [
            f'no {name.removesuffix("_age_s")} for {age_s:.0f} s'
            for name, age_s in self._inputs.ages_s.items()
            if age_s > stale_input_s
        ]

    def _losses(self) -> list[str]:
        dropped, lost = self._dropped(), self._inputs.lost
        news = {
            'scans are dropped: more come than can be added': dropped > self._reported_drops,
            'scans are lost on the way here: see "Large clouds"': lost > self._reported_losses,
        }
        self._reported_drops, self._reported_losses = dropped, lost
        return [text for text, is_new in news.items() if is_new]

    def _dropped(self) -> int:
        return self._scans.dropped + self._inputs.unlocated
