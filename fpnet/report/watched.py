# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Live page of a localizer that runs in another process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Self

from fpnet.report.live import LiveRun
from fpnet.report.record import RunRecord
from fpnet_core.io.serialization import ShownPlan, ShownTick
from fpnet_core.localizer.kept import in_brief
from fpnet_core.trajectory import PlanarTrajectory

_REMEMBERED = 3600  # numerical: updates, about an hour, besides the first one, the time origin


class WatchedRun:
    """
    Live page of a running localizer; use it in a ``with`` statement.

    Parameters
    ----------
    port : port of the page, on this machine; 0 takes a free one
    tell : called with the URL once a floorplan has come, and with messages before that
    """

    def __init__(self, port: int, tell: Callable[[str], None]) -> None:
        self._port, self._tell, self._said = port, tell, ''
        self._live: LiveRun | None = None
        self._number = 0
        self._record: RunRecord | None = None

    def take(self, heard: ShownPlan | ShownTick | str) -> None:
        """
        Show a floorplan, an update on it, or a message.

        Raises
        ------
        FpnetError
            If the port is taken.
        """
        if isinstance(heard, ShownPlan):
            self._begin(heard)
        elif isinstance(heard, ShownTick):
            self._show(heard)
        else:
            self._say(heard)

    def end(self, said: str) -> None:
        """Show that the run has ended, with the last message."""
        if self._live is not None:
            self._live.end(f'{said}; last message: {self._said}')

    def _begin(self, plan: ShownPlan) -> None:
        title = f'live on {plan.name}' if plan.name else 'live'
        self._number, self._record = plan.number, RunRecord(title, '', plan.rooms)
        if self._live is None:
            self._live = LiveRun(title, plan.rooms, self._port)
            self._tell(f'watch it at {self._live.url}')
        else:
            self._live.begin(title, plan.rooms)

    def _show(self, update: ShownTick) -> None:
        record = self._record
        if self._live is None or record is None or update.number != self._number:
            return
        if record.outputs and update.output.stamp_ns < record.outputs[-1].stamp_ns:
            record = RunRecord(record.title, '', record.plan)  # time jumped back
            self._live.begin(record.title, record.plan)
        self._record = record = with_update(record, update)
        is_its = self._said.startswith(update.output.said)
        self._live.show(record, self._said if is_its else '')

    def _say(self, said: str) -> None:
        if self._live is not None:
            self._live.say(said)
        elif said != self._said:
            self._tell(said)
        self._said = said

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the page, if there is one."""
        if self._live is not None:
            self._live.close()


def with_update(record: RunRecord, update: ShownTick) -> RunRecord:
    """Return the record with another update; of earlier ones, only the brief form is kept."""
    before = map(in_brief, record.outputs[-1:])
    outputs = (*record.outputs[:-1], *before, update.output)
    if len(outputs) > _REMEMBERED:
        outputs = (outputs[0], *outputs[-_REMEMBERED:])
    submap, odometry = update.output.submap, record.odometry
    if submap is not None and update.T_odom_base is not None:
        newest = PlanarTrajectory.of([(submap.stamp_ns, update.T_odom_base)])
        odometry = _joined(odometry, newest)
    published = _joined(record.published, update.poses)
    return replace(record, outputs=outputs, published=published, odometry=odometry)


def _joined(first: PlanarTrajectory, second: PlanarTrajectory) -> PlanarTrajectory:
    """Return the poses of both; poses of the second that are not later are dropped."""
    last_ns = first.stamps_ns[-1:]
    return first.joined(second.take(second.stamps_ns > (last_ns[0] if len(last_ns) else -1)))
