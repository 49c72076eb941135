# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Planar scanners on a robot: points in the base frame, and merging of several scanners."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import CloudFormatError
from fpnet_core.geometry.motion import carried
from fpnet_core.io.laserscan import LaserPoints
from fpnet_core.stamps import NS_PER_S

MAX_TILT_RAD = math.radians(3.0)
"""Physical: a beam 0.3 m above the floor that is tilted further hits it within 6 m."""

SAME_SWEEP_NS = 200_000_000
"""Physical: two turns of common scanners; sweeps further apart are not merged."""


@dataclass(frozen=True, eq=False)
class LaserSweep:
    """
    Points of one or more planar scanners, in the frame of the robot's base.

    Parameters
    ----------
    points : (P, 3) float32
        Each relative to the base at the point's own time, z = 0 [m].
    stamps_ns : (P,) int64
        Time of each point.
    viewpoints : (P, 3) float32
        Origin of each point's ray, z = 0 [m].
    stamp_ns : int
        Time of the last point; the message's stamp if the sweep has no points.
    """

    points: NDArray[np.float32]
    stamps_ns: NDArray[np.int64]
    viewpoints: NDArray[np.float32]
    stamp_ns: int

    @property
    def first_ns(self) -> int:
        """Time of the first point."""
        return int(self.stamps_ns.min()) if len(self.stamps_ns) else self.stamp_ns

    @property
    def time_s(self) -> NDArray[np.float64]:
        """Times of the points ``(P,)`` since the first one [s]."""
        seconds: NDArray[np.float64] = (self.stamps_ns - self.first_ns) / NS_PER_S
        return seconds

    def without_motion(self, T_first_last: NDArray[np.float64]) -> LaserSweep:
        """Deskew: return all points relative to the base's pose at ``stamp_ns``."""
        span_ns = self.stamp_ns - self.first_ns
        if not span_ns:
            return self
        share = (self.stamps_ns - self.stamp_ns) / span_ns
        return LaserSweep(
            carried(self.points, T_first_last, share).astype(np.float32),
            np.full_like(self.stamps_ns, self.stamp_ns),
            carried(self.viewpoints, T_first_last, share).astype(np.float32),
            self.stamp_ns,
        )


def mounted(
    laser: LaserPoints, stamp_ns: int, T_base_laser: NDArray[np.float64], name: str
) -> LaserSweep:
    """
    Return a scanner's points in the frame of the base, with z = 0.

    The height is dropped, as walls look alike at any height. The scanner may be upside down.

    Parameters
    ----------
    stamp_ns : int
        Stamp of the message: the time of its first ray.
    T_base_laser : (4, 4)
        Mount of the scanner.
    name : str
        Name of the scanner's frame, for the error.

    Raises
    ------
    CloudFormatError
        If the scanner is tilted by more than ``MAX_TILT_RAD``.
    """
    upright = min(1.0, abs(float(T_base_laser[2, 2])))
    if upright < math.cos(MAX_TILT_RAD):
        raise CloudFormatError(
            f'laser {name!r} is tilted by {math.degrees(math.acos(upright)):.1f} degrees; its '
            'beam would see the floor or ceiling as walls: mount it level (at most '
            f'{math.degrees(MAX_TILT_RAD):.0f} degrees), or correct its transform'
        )
    points = laser.points @ T_base_laser[:3, :3].T + T_base_laser[:3, 3]
    points[:, 2] = 0.0
    viewpoint = np.array([T_base_laser[0, 3], T_base_laser[1, 3], 0.0], dtype=np.float32)
    stamps_ns = stamp_ns + np.round(laser.time_s * NS_PER_S).astype(np.int64)
    return LaserSweep(
        points.astype(np.float32),
        stamps_ns,
        np.tile(viewpoint, (len(points), 1)),
        int(stamps_ns.max()) if len(stamps_ns) else stamp_ns,
    )


def merged(sweeps: Sequence[LaserSweep]) -> LaserSweep:
    """Merge one or more sweeps; the stamp is the latest of theirs."""
    if len(sweeps) == 1:
        return sweeps[0]
    return LaserSweep(
        np.concatenate([sweep.points for sweep in sweeps]),
        np.concatenate([sweep.stamps_ns for sweep in sweeps]),
        np.concatenate([sweep.viewpoints for sweep in sweeps]),
        max(sweep.stamp_ns for sweep in sweeps),
    )


class SweepMerger:
    """
    Merges the sweeps of several scanners, one of each, in the order in which they arrive.

    A merged sweep is complete once it has one sweep of every scanner. It is returned early if a
    scanner repeats first, so that slow or dead scanners do not block. Each sweep is used once.

    Parameters
    ----------
    scanners : int
        Number of scanners.
    """

    def __init__(self, scanners: int) -> None:
        self._scanners = scanners
        self._waiting: dict[str, LaserSweep] = {}

    def add(self, name: str, sweep: LaserSweep) -> list[LaserSweep]:
        """Add the next sweep of a scanner; return zero, one or two merged sweeps."""
        done: list[LaserSweep] = []
        apart_ns = max(
            (abs(sweep.stamp_ns - s.stamp_ns) for s in self._waiting.values()), default=0
        )
        if name in self._waiting or apart_ns > SAME_SWEEP_NS:
            done += self.flush()
        self._waiting[name] = sweep
        if len(self._waiting) == self._scanners:
            done += self.flush()
        return done

    def flush(self) -> list[LaserSweep]:
        """Return the pending sweeps, merged; call at the end of a recording."""
        waiting, self._waiting = list(self._waiting.values()), {}
        return [merged(waiting)] if waiting else []
