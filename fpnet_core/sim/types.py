# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the simulator means by a building: labelled rooms, doors and walls, in metres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class PlanRoom:
    """A room's inner outline ``polygon (V, 2)`` [m], counter-clockwise, not closed."""

    polygon: NDArray[np.float64]
    kind: Literal['room', 'corridor', 'hall'] = 'room'


@dataclass(frozen=True, eq=False)
class PlanDoor:
    """
    An opening ``ends (2, 2)`` [m] in the middle of the wall between two rooms (indices).

    ``is_open`` marks a passage of full height, without lintel, frame or leaf: the seam between
    two pieces of one corridor.
    """

    rooms: tuple[int, int]
    ends: NDArray[np.float64]
    is_open: bool = False

    @property
    def width_m(self) -> float:
        """Length of the opening [m]."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))


@dataclass(frozen=True, eq=False)
class BuildingPlan:
    """
    The true layout of a building, frame ``building`` [m].

    Rooms do not overlap; between two rooms lies a wall of about ``wall_m`` thickness, and the
    outer wall surrounds them all. ``family`` names the generator's layout family.
    """

    rooms: tuple[PlanRoom, ...]
    doors: tuple[PlanDoor, ...]
    wall_m: float
    family: str

    @property
    def extent(self) -> NDArray[np.float64]:
        """Lower and upper corner ``(2, 2)`` of all room outlines [m]."""
        points = np.concatenate([room.polygon for room in self.rooms])
        return np.stack([points.min(axis=0), points.max(axis=0)])
