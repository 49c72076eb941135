# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Live or replayed run on a page of this machine: the report, which grows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
import json
from pathlib import Path
from typing import Any, Self

import numpy as np

from fpnet.report.charts import timeline_figure
from fpnet.report.moments import MAX_MOMENTS, changes, chosen_updates, moment
from fpnet.report.page import page_text, read_content
from fpnet.report.record import RunRecord
from fpnet.report.run_page import published, run_data, run_figures, run_values
from fpnet.report.serving import LiveServer
from fpnet_core.errors import FpnetError
from fpnet_core.types import Segmentation

_TIMELINES = 100  # numerical: up to so many updates each one sends the timeline, later fewer do

_SHOWN_MOMENTS = 2 * MAX_MOMENTS
"""Numerical: more are thinned out to about half, as a page may stay open for days."""


class LiveRun:
    """
    Live page of a run; use it in a ``with`` statement.

    Parameters
    ----------
    title : title of the page
    plan : the floorplan
    port : port on this machine; 0 takes a free one

    Raises
    ------
    FpnetError
        If the port is taken.
    """

    def __init__(self, title: str, plan: Segmentation, port: int) -> None:
        self._record, self._said = RunRecord(title, '', plan), ''
        self._moments: list[dict[str, Any]] = []
        self._server = LiveServer(_growing(self._record), self._whole, port)

    @property
    def url(self) -> str:
        """URL of the page."""
        return self._server.url

    def show(self, record: RunRecord) -> None:
        """Show a run whose last update is new."""
        record = replace(record, title=self._record.title)
        count, new = len(record.outputs), np.s_[len(self._record.published) :]
        if not count:
            return
        if record.plan is not self._record.plan:  # another storey, or its scale is known now
            before = replace(self._record, plan=record.plan)
            self._server.replace(_growing(before), partial(setattr, self, '_record', before))
        shown = moment(record, record.outputs[-1])
        is_drawn = count % max(1, count // _TIMELINES) == 0
        event = {
            'kind': 'update',
            'moment': shown,
            'published': published(record, new),
            'changes': changes(record),
            'timeline': _timeline(record) if is_drawn else None,
        }
        self._server.tell(event, partial(self._take, record, shown))
        if len(self._moments) > _SHOWN_MOMENTS:
            self._thin_out()

    def end(self, said: str) -> None:
        """Show how the run ended; open pages stay as they are."""
        self._server.tell({'kind': 'end', 'said': said}, partial(setattr, self, '_said', said))

    def _take(self, record: RunRecord, shown: dict[str, Any]) -> None:
        self._record = record
        self._moments.append(shown)

    def _thin_out(self) -> None:
        kept = chosen_updates([each['status'] for each in self._moments])
        self._moments = [self._moments[index] for index in kept]
        self._server.tell(self._whole(), lambda: None)

    def _whole(self) -> dict[str, Any]:
        record, moments = self._record, list(self._moments)
        timeline, data = _timeline(record), run_data(record, moments)
        return {'kind': 'run', 'data': data, 'timeline': timeline, 'said': self._said}

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the page's server."""
        self.close()

    def close(self) -> None:
        """Close the page's server."""
        self._server.close()


class RecordedRun:
    """
    Replay of a run's report, update by update, on a live page.

    Parameters
    ----------
    report : ``report.html`` of ``fpnet localize --out``
    port : port on this machine; 0 takes a free one

    Raises
    ------
    FpnetError
        If the file is not a run report, or the port is taken.
    """

    def __init__(self, report: Path, port: int) -> None:
        content = read_content(report)
        self._data, self._shown, self._said = content['data'], 0, ''
        self._timeline = content['figures']['timeline']
        if 'moments' not in self._data:
            raise FpnetError(f'{report} is not the report of a run; give the folder of one')
        empty = self._data | {'moments': [], 'changes': []}
        page = _page(content['figures'], empty)
        self._server = LiveServer(page, self._whole, port)

    @property
    def url(self) -> str:
        """URL of the page."""
        return self._server.url

    def __iter__(self) -> Iterator[float]:
        """Show the updates one after the other; yield the time [s] of each before it."""
        for index, each in enumerate(self._data['moments']):
            yield each['time_s']
            event = {'kind': 'update', 'moment': each, 'changes': self._changes(each['time_s'])}
            self._server.tell(event, partial(setattr, self, '_shown', index + 1))

    def end(self, said: str) -> None:
        """Show that the replay has ended."""
        self._server.tell({'kind': 'end', 'said': said}, partial(setattr, self, '_said', said))

    def _changes(self, until_s: float) -> list[Any]:
        return [change for change in self._data['changes'] if change['time_s'] <= until_s]

    def _whole(self) -> dict[str, Any]:
        shown = self._data['moments'][: self._shown]
        until_s = shown[-1]['time_s'] if shown else -np.inf
        data = self._data | {'moments': shown, 'changes': self._changes(until_s)}
        return {'kind': 'run', 'data': data, 'timeline': self._timeline, 'said': self._said}

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the page's server."""
        self._server.close()


def _timeline(record: RunRecord) -> Any:
    return json.loads(timeline_figure(record).to_json())


def _growing(record: RunRecord) -> str:
    """Return the page of a run without updates."""
    return _page(run_figures(record), run_data(record, []))


def _page(figures: Mapping[str, Any], data: Mapping[str, Any]) -> str:
    values = run_values(data['summary'], 0)
    return page_text('run.html.j2', figures, {**data, 'live': True}, **values)
