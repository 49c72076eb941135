# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Local metric coordinates of longitudes and latitudes: equirectangular projection."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_AXIS_M = 6_378_137.0  # given: WGS 84, semi-major axis
_ECCENTRICITY2 = 6.694379990141e-3  # given: WGS 84, eccentricity squared

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LocalMetres:
    """Local metric frame, x east and y north, with its origin at a position in degrees."""

    longitude: float
    latitude: float

    @property
    def metres_per_degree(self) -> Array:
        """Metres per degree ``(2,)``, east and north."""
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
