# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Interval of the scale of a floorplan grid, which an ``OccupancyGrid`` cannot hold.

It is a ``diagnostic_msgs/DiagnosticArray`` with the grid's stamp. The scale of a grid without one,
for example of map_server, counts as stated.
"""

from __future__ import annotations

from dataclasses import dataclass, field
import math
from typing import Any

from fpnet_core.errors import MapFormatError
from msg_adapters.diagnostics import OK, WARN, diagnostics_to_msg, named_status_to_msg
from msg_adapters.stamps import stamp_from_msg

_NAME = 'floorplan: scale'


@dataclass(frozen=True)
class GridScale:
    """
    Scale of the grid with this stamp.

    True metres per metre of the grid lie between ``low`` and ``high`` with 90 % probability; both
    are 1 if the scale is stated. ``said`` is text for people.
    """

    stamp_ns: int
    low: float = 1.0
    high: float = 1.0
    said: str = field(default='', compare=False)

    @property
    def is_stated(self) -> bool:
        """Return whether the scale is stated."""
        return self.low == self.high == 1.0


def scale_to_msg(scale: GridScale) -> Any:
    """Return a DiagnosticArray."""
    values = {'low': repr(scale.low), 'high': repr(scale.high)}
    level = OK if scale.is_stated else WARN
    status = named_status_to_msg(level, _NAME, scale.said, values)
    return diagnostics_to_msg([status], scale.stamp_ns)


def scale_from_msg(msg: Any) -> GridScale:
    """
    Return the scale in a message of :func:`scale_to_msg`.

    Raises
    ------
    MapFormatError
        If it is not one.
    """
    found = [status for status in msg.status if status.name == _NAME]
    try:
        (status,) = found
        values = {entry.key: float(entry.value) for entry in status.values}
        low, high = values['low'], values['high']
    except (ValueError, KeyError) as error:
        raise MapFormatError(f'the scale of a floorplan is unreadable: {error}') from None
    if not (0.0 < low <= high < math.inf):
        raise MapFormatError(f'the scale of a floorplan is out of range: {low:g} to {high:g}')
    return GridScale(stamp_from_msg(msg.header.stamp), low, high, status.message)
