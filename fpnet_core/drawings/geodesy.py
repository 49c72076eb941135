# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Longitudes and latitudes as metres about a place: equirectangular, true within a building."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_AXIS_M = 6_378_137.0  # given: WGS 84, half of the equator's diameter
_ECCENTRICITY2 = 6.694379990141e-3  # given: WGS 84, squared

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LocalMetres:
    """A place on Earth, in degrees, about which metres are counted: x to the east, y north."""

    longitude: float
    latitude: float

    @property
    def metres_per_degree(self) -> Array:
        """``(2,)`` to the east and to the north."""
        sine = np.sin(np.radians(self.latitude))
        root = 1.0 - _ECCENTRICITY2 * sine**2
        across = _AXIS_M / np.sqrt(root) * np.cos(np.radians(self.latitude))
        along = _AXIS_M * (1.0 - _ECCENTRICITY2) / root**1.5
        return np.array([across, along]) * np.pi / 180.0

    def to_metres(self, degrees: Array) -> Array:
        """Map ``(..., 2)`` longitudes and latitudes [degrees] to metres."""
        metres: Array = (degrees - (self.longitude, self.latitude)) * self.metres_per_degree
        return metres

    def to_degrees(self, metres: Array) -> Array:
        """Map places ``(..., 2)`` [m] to longitudes and latitudes [degrees]."""
        degrees: Array = metres / self.metres_per_degree + (self.longitude, self.latitude)
        return degrees
