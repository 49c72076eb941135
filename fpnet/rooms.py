# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Named rooms of a floorplan: the room at a point, and the rooms that a trajectory visits."""

from __future__ import annotations

from collections.abc import Sequence
import csv
from dataclasses import dataclass
from datetime import UTC, datetime
import io
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fpnet_core.drawings.room_names import room_names
from fpnet_core.drawings.types import Reading, RoomName
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import Segmentation

_MS = 3  # numerical: decimals of a time in seconds


@dataclass(frozen=True)
class RoomStay:
    """A stay in the room ``name``, from the first to the last pose in it [ns]."""

    name: str
    entered_ns: int
    left_ns: int

    def as_json(self) -> dict[str, Any]:
        """Return the stay as JSON values, times in seconds."""
        entered_s, left_s = (round(t / NS_PER_S, _MS) for t in (self.entered_ns, self.left_ns))
        return {'room': self.name, 'entered_s': entered_s, 'left_s': left_s}


class NamedRooms:
    """
    The rooms of a segmented floorplan that have a name.

    Parameters
    ----------
    segmentation : rooms of the floorplan
    names : names with a point in their room, in metres of the floorplan's frame; several names in
        one room are joined, as their rooms were not told apart
    """

    def __init__(self, segmentation: Segmentation, names: Sequence[RoomName]) -> None:
        self._segmentation = segmentation
        labels = self._labels([each.xy for each in names])
        self.names: dict[int, str] = {}
        """The names by the rooms' ids."""
        for label, each in zip(labels, names, strict=True):
            if label:
                before = self.names.get(label - 1)
                self.names[label - 1] = f'{before} / {each.name}' if before else each.name

    @classmethod
    def of(cls, plan: Reading) -> NamedRooms:
        """Return the named rooms of a parsed floorplan."""
        names = room_names(plan)
        return cls(plan.segmentation, names)

    def __len__(self) -> int:
        """Count the rooms with a name."""
        return len(self.names)

    def at(self, xy: ArrayLike) -> list[str]:
        """Return the room's name at each point ``xy (N, 2)`` [m]; empty where there is none."""
        return [self.names.get(label - 1, '') for label in self._labels(xy)]

    def stays(self, path: PlanarTrajectory) -> tuple[RoomStay, ...]:
        """
        Return the stays in named rooms along a trajectory in the floorplan's frame.

        Doorways and rooms without a name do not end a stay.
        """
        named = zip(self.at(path.xy), path.stamps_ns.tolist(), strict=True)
        found = []
        for name, poses in groupby((each for each in named if each[0]), key=lambda each: each[0]):
            stamps_ns = [stamp_ns for _, stamp_ns in poses]
            found.append(RoomStay(name, stamps_ns[0], stamps_ns[-1]))
        return tuple(found)

    def _labels(self, xy: ArrayLike) -> list[int]:
        """Return the room's label at each point, 0 outside of rooms."""
        points = np.asarray(xy, dtype=np.float64).reshape(-1, 2)
        cells = np.round(self._segmentation.grid.xy_to_rc(points)).astype(np.int64)
        inside = np.all((cells >= 0) & (cells < self._segmentation.labels.shape), axis=1)
        rows, cols = np.where(inside[:, None], cells, 0).T
        found: list[int] = np.where(inside, self._segmentation.labels[rows, cols], 0).tolist()
        return found


def write_stays(path: Path, stays: Sequence[RoomStay]) -> None:
    """Write stays as CSV: room, times in seconds since the epoch, and the time of entry in UTC."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator='\n')
    table.writerow(('room', 'entered_s', 'left_s', 'entered_utc'))
    for stay in stays:
        at = datetime.fromtimestamp(stay.entered_ns / NS_PER_S, UTC)
        table.writerow((*stay.as_json().values(), at.isoformat(timespec='seconds')))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text.getvalue(), encoding='utf-8')
