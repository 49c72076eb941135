# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Lidar models by name: ray directions, firing times and errors.

Angles are in the sensor frame (x ahead, y left, z up), azimuth counter-clockwise seen from above.
A sweep has ``columns`` instants (C) with ``beams`` rays each (B). Rays of one instant share a
pose, so that motion distorts a sweep like that of a real sensor.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class SensorModel(ABC):
    """
    Base class of lidar models.

    Parameters
    ----------
    beams : int
        Rays per instant; the ray index is the ring of a point.
    columns : int
        Instants of a sweep, evenly spaced in time.
    period_s : float
        Duration of a sweep [s].
    min_range_m, max_range_m : float
        Returns outside of this interval are not reported [m].
    range_sigma_m : float
        Standard deviation of the measured range [m].
    angle_sigma_rad : float
        Standard deviation of every ray's azimuth and elevation around the regular pattern [rad].
        The sensor is calibrated, so points are reported along the actual ray.
    dropout : float
        Share of returns that are lost regardless of the surface.
    """

    beams: int
    columns: int
    period_s: float = 0.1
    min_range_m: float = 0.3
    max_range_m: float = 60.0
    range_sigma_m: float = 0.015
    angle_sigma_rad: float = float(np.deg2rad(0.1))
    dropout: float = 0.01

    @property
    def column_times_s(self) -> Array:
        """Time ``(C,)`` of each instant from the start of the sweep [s]."""
        return np.arange(self.columns, dtype=np.float64) * (self.period_s / self.columns)

    @abstractmethod
    def angles(self, start_s: float, rng: np.random.Generator) -> tuple[Array, Array]:
        """
        Return the azimuths and elevations of the regular pattern [rad].

        Both broadcast to ``(C, B)``; ``start_s`` is the sensor clock at the sweep's start.
        """

    def directions(self, start_s: float, rng: np.random.Generator) -> NDArray[np.float32]:
        """Return unit ray directions ``(C, B, 3)`` in the sensor frame, including jitter."""
        azimuth, elevation = (a.astype(np.float32) for a in self.angles(start_s, rng))
        sigma = np.float32(self.angle_sigma_rad)
        noise = sigma * rng.standard_normal((2, self.columns, self.beams), dtype=np.float32)
        azimuth, elevation = azimuth + noise[0], elevation + noise[1]
        level = np.cos(elevation)
        return np.stack(
            [level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1
        )


@dataclass(frozen=True, kw_only=True)
class LidarModel(SensorModel):
    """
    A spinning lidar with vertically stacked beams; with one beam, a planar scanner.

    Beams are evenly spaced from ``lowest_rad`` (ring 0) to ``highest_rad``; a sweep is one turn.
    The default resembles a common 32-beam sensor.
    """

    beams: int = 32
    columns: int = 720
    lowest_rad: float = float(np.deg2rad(-22.5))
    highest_rad: float = float(np.deg2rad(22.5))

    def angles(self, start_s: float, rng: np.random.Generator) -> tuple[Array, Array]:
        """Return angles that broadcast to ``(C, B)``, with a random start azimuth."""
        phase = rng.random()  # the encoder is not synchronised with the sweep
        azimuth = (np.arange(self.columns) + phase) * (2.0 * np.pi / self.columns)
        elevation = np.linspace(self.lowest_rad, self.highest_rad, self.beams)
        return np.asarray(azimuth[:, None]), np.asarray(elevation[None, :])


@dataclass(frozen=True, kw_only=True)
class DomeLidar(SensorModel):
    """
    A lidar with a 360 x 59 degree field of view and a non-repeating pattern.

    A few lines, one above the other, divide the vertical field of view. While the head turns,
    each scans its part many times: points of a sweep are about one degree apart in all directions.
    No rate is a multiple of another or of the sweep rate, so successive scans fill the gaps.
    Indoors it measures walls and the ceiling, and the floor only at some distance.
    """

    beams: int = 4
    columns: int = 5000
    lowest_rad: float = float(np.deg2rad(-7.0))
    highest_rad: float = float(np.deg2rad(52.0))
    max_range_m: float = 40.0
    range_sigma_m: float = 0.02
    turns_per_s: float = 10.0 * (np.sqrt(5.0) + 1.0) / 3.0
    strokes_per_s: float = 600.0 * np.sqrt(7.0)

    def angles(self, start_s: float, rng: np.random.Generator) -> tuple[Array, Array]:
        """Return angles that broadcast to ``(C, B)``."""
        time_s = (start_s + self.column_times_s)[:, None]
        azimuth = 2.0 * np.pi * (self.turns_per_s * time_s % 1.0)
        stroke = 2.0 * (self.strokes_per_s * time_s % 1.0)
        height = np.where(stroke > 1.0, 2.0 - stroke, stroke)  # triangle wave
        share = (np.arange(self.beams) + height) / self.beams
        return azimuth, self.lowest_rad + share * (self.highest_rad - self.lowest_rad)


@dataclass(frozen=True, kw_only=True)
class RosetteLidar(SensorModel):
    """
    A forward-looking lidar with two rotating wedge prisms and a rosette pattern.

    Each prism deflects the ray by half of ``half_view_rad``. To first order the deflections add
    as vectors, so at time t the ray's angle to the axis is
    ``half_view_rad / 2 * (exp(2 pi i f1 t) + exp(2 pi i f2 t))`` (Risley prisms). The petals
    shift from scan to scan, as f1 / f2 is not a ratio of small integers.
    """

    beams: int = 1
    columns: int = 10000
    half_view_rad: float = float(np.deg2rad(35.0))
    max_range_m: float = 40.0
    range_sigma_m: float = 0.02
    prisms_per_s: tuple[float, float] = (121.57, -77.73)

    def angles(self, start_s: float, rng: np.random.Generator) -> tuple[Array, Array]:
        """Return angles ``(C, 1)``."""
        time_s = start_s + self.column_times_s
        off = sum(np.exp(2j * np.pi * (rate * time_s % 1.0)) for rate in self.prisms_per_s)
        off = np.asarray(off * (self.half_view_rad / 2.0))[:, None]
        angle, bearing = np.abs(off), np.angle(off)
        left, up = np.sin(angle) * np.cos(bearing), np.sin(angle) * np.sin(bearing)
        return np.arctan2(left, np.cos(angle)), np.arcsin(up)


def _spinning(beams: int, half_view_deg: float, columns: int) -> LidarModel:
    half_view_rad = float(np.deg2rad(half_view_deg))
    return LidarModel(
        beams=beams, columns=columns, lowest_rad=-half_view_rad, highest_rad=half_view_rad
    )


SENSORS: dict[str, SensorModel] = {
    'beams16': _spinning(16, 15.0, 900),
    'beams32': _spinning(32, 22.5, 720),
    'beams64': _spinning(64, 45.0, 512),
    'dome': DomeLidar(),
    'rosette': RosetteLidar(),
    'planar': LidarModel(
        beams=1,
        columns=1080,
        lowest_rad=0.0,
        highest_rad=0.0,
        max_range_m=25.0,
        range_sigma_m=0.02,
        angle_sigma_rad=0.0,  # points lie exactly at z = 0, as drivers report them
    ),
}
"""Sensor models by name; ``dome`` and ``rosette`` have non-repeating patterns. Chosen."""
