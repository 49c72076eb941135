# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Lidars by name: where their rays go, when, and what errors they make.

Angles are in the sensor frame (x ahead, y left, z up), azimuth counter-clockwise seen from above.
A sweep has ``columns`` instants (C) with ``beams`` rays each (B): rays of one instant share a
pose, so that the motion during a sweep distorts it as it does a real one.
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
    What all lidars have in common.

    Parameters
    ----------
    beams : int
        Rays per instant; their number is the ring of a point.
    columns : int
        Instants of a sweep, evenly spread over its time.
    period_s : float
        Duration of a sweep [s].
    min_range_m, max_range_m : float
        Returns outside are not reported [m].
    range_sigma_m : float
        Standard deviation of the measured range [m].
    angle_sigma_rad : float
        Standard deviation of every ray's azimuth and elevation around the regular pattern; the
        sensor's calibration knows it, so points are reported where the ray went [rad].
    dropout : float
        Share of returns that get lost whatever they hit.
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
        Return azimuths and elevations of the regular pattern [rad].

        Both broadcast to ``(C, B)``; ``start_s`` is the sensor's clock at the sweep's start.
        """

    def directions(self, start_s: float, rng: np.random.Generator) -> NDArray[np.float32]:
        """Return unit ray directions ``(C, B, 3)`` in the sensor frame, jitter included."""
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
    A spinning lidar with its beams stacked one above the other; one beam is a planar scanner.

    Beams spread evenly from ``lowest_rad`` (ring 0) to ``highest_rad``; a sweep is one turn. The
    default resembles a common 32-beam sensor.
    """

    beams: int = 32
    columns: int = 720
    lowest_rad: float = float(np.deg2rad(-22.5))
    highest_rad: float = float(np.deg2rad(22.5))

    def angles(self, start_s: float, rng: np.random.Generator) -> tuple[Array, Array]:
        """Return angles that broadcast to ``(C, B)``; the turn starts anywhere."""
        phase = rng.random()  # the encoder is not synchronised with the sweep
        azimuth = (np.arange(self.columns) + phase) * (2.0 * np.pi / self.columns)
        elevation = np.linspace(self.lowest_rad, self.highest_rad, self.beams)
        return np.asarray(azimuth[:, None]), np.asarray(elevation[None, :])


@dataclass(frozen=True, kw_only=True)
class DomeLidar(SensorModel):
    """
    A sensor of 360 x 59 degrees that never repeats its pattern.

    A few lines, one above the other, share the vertical field of view; while the head turns,
    each sweeps its part many times: points of a sweep are about a degree apart in all directions.
    Neither rate is a multiple of the other or of the sweep's, so scan after scan fills the gaps.
    Indoors it sees walls and the ceiling, and the floor only from some way off.
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
        height = np.where(stroke > 1.0, 2.0 - stroke, stroke)  # up and down again
        share = (np.arange(self.beams) + height) / self.beams
        return azimuth, self.lowest_rad + share * (self.highest_rad - self.lowest_rad)


@dataclass(frozen=True, kw_only=True)
class RosetteLidar(SensorModel):
    """
    A sensor that looks ahead through two turning wedge prisms and draws a rosette.

    Each prism deflects the ray by half of ``half_view_rad``; to first order the deflections add
    as vectors, so at time t the ray is off the axis by
    ``half_view_rad / 2 * (exp(2 pi i f1 t) + exp(2 pi i f2 t))`` (Risley prisms), whose petals
    move on from scan to scan as f1 / f2 is no ratio of small integers.
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
        angle_sigma_rad=0.0,  # its points lie in z = 0 exactly, as drivers report them
    ),
}
"""Sensor models by name; ``dome`` and ``rosette`` do not repeat their pattern. Chosen."""
