# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Estimate of floor and ceiling heights from returns, and the height bands in between."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SubmapConfig

# Physical: lowest lintel above the floor, a low door; higher returns may be a lintel.
LINTEL_HEIGHT_M = 1.95
LINTEL_TOP_M = 2.45  # physical: highest lintel; higher returns are no lintels
# Higher rays prove no free space: high walls are uneven; fitted to development recordings
# (notes/submaps.md).
_CARVE_TOP_M = 3.0

# Numerical: histogram of heights relative to the sensor: bin edge and reach [m].
_BIN_M = 0.05
_REACH_M = 6.0  # numerical
# Chosen, not measured:
# Decay of older scans' weight per scan, so that the floor follows drift in z.
_DECAY = 0.98
# A floor or ceiling is a bin (with its neighbours) that holds at least this share of all returns,
# and this many times the mean of the wall bins above or below it [bins].
_PLANE_SHARE, _STANDS_OUT = 0.03, 1.5
_WALL_BINS = range(5, 11)
# With the floor out of view, part of the walls may look like one. A floor that is nearer to the
# sensor than the known one by this much [m] must hold this larger share, as nearby floors do, with
# at most this share of all returns below it.
_NEARER_M, _NEARER_SHARE, _BELOW_SHARE = 0.3, 0.15, 0.02
_BELOW_BINS = 4
# Returns within this height of the sensor are never floor or ceiling [m].
_CLEAR_OF_SENSOR_M = 0.2
# A scan is planar if its returns' elevation angles spread less than this [rad].
_PLANAR_SPREAD_RAD = math.radians(1.0)
# Returns and rays nearer to the ceiling than this are not used for lintels [m].
_CEILING_MARGIN_M = 0.15


@dataclass(frozen=True)
class HeightBands:
    """
    Height limits in the odometry frame that classify rays and returns [m].

    ``body_low..body_high``: returns are walls or furniture, rays prove free space;
    ``high_low..high_high``: returns over free space are lintels; ``high_low..ceiling``: rays prove
    free space as well.
    """

    body_low: float
    body_high: float
    high_low: float
    high_high: float
    ceiling: float

    @property
    def limits(self) -> tuple[float, float, float, float, float]:
        """The heights in order, for compiled code."""
        return self.body_low, self.body_high, self.high_low, self.high_high, self.ceiling

    @classmethod
    def planar(cls) -> HeightBands:
        """Return bands for a planar scanner: every height is body height."""
        return cls(-math.inf, math.inf, math.inf, math.inf, math.inf)


class HeightTracker:
    """Tracker of floor and ceiling in a recency-weighted histogram of return heights."""

    def __init__(self, config: SubmapConfig) -> None:
        self._config = config
        self._counts = np.zeros(round(2.0 * _REACH_M / _BIN_M), dtype=np.float64)
        self._base_m: float | None = None
        self._sensor_height_m = config.sensor_height_m

    def update(
        self, points: NDArray[np.float64], heights: NDArray[np.float64], sensor_z_m: float
    ) -> HeightBands:
        """
        Add one scan and return the bands to use for it.

        ``points (P, 3)`` in the sensor frame identify planar scanners; ``heights (P,)`` are their
        z in odom and ``sensor_z_m`` is the sensor's. Without a visible floor the last height of
        the sensor above it is kept, initially the configured one.
        """
        elevation = np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]))
        if np.ptp(elevation) < _PLANAR_SPREAD_RAD:
            return HeightBands.planar()
        if self._base_m is None:
            self._base_m = sensor_z_m - _REACH_M
        self._follow(sensor_z_m)
        index = np.floor((heights - self._base_m) / _BIN_M)
        index = index[(index >= 0) & (index < len(self._counts))].astype(np.int64)
        self._counts *= _DECAY
        self._counts += np.bincount(index, minlength=len(self._counts))
        return self._bands(sensor_z_m)

    def arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return the histogram, its lowest height (NaN: no scan) and the sensor's height [m]."""
        base_m = math.nan if self._base_m is None else self._base_m
        return {
            'histogram': self._counts.copy(),
            'heights_m': np.array([base_m, self._sensor_height_m]),
        }

    @classmethod
    def restored(
        cls, config: SubmapConfig, histogram: NDArray[np.float64], heights_m: NDArray[np.float64]
    ) -> Self:
        """Return a tracker that continues from :meth:`arrays`; ValueError for other shapes."""
        tracker = cls(config)
        if histogram.shape != tracker._counts.shape or histogram.dtype != np.float64:
            raise ValueError(f'height histogram: got {histogram.shape} {histogram.dtype}')
        if heights_m.shape != (2,) or heights_m.dtype != np.float64:
            raise ValueError(f'heights: expected (2,) float64, got {heights_m.shape}')
        if not np.isfinite(histogram).all():
            raise ValueError('height histogram: not finite')
        tracker._counts = histogram.astype(np.float64)
        base_m, tracker._sensor_height_m = map(float, heights_m)
        tracker._base_m = None if math.isnan(base_m) else base_m
        return tracker

    def _follow(self, sensor_z_m: float) -> None:
        """Shift the histogram by whole bins so that the sensor stays in its middle."""
        assert self._base_m is not None
        shift = round((sensor_z_m - _REACH_M - self._base_m) / _BIN_M)
        if shift == 0:
            return
        size = len(self._counts)
        moved = np.zeros_like(self._counts)
        if abs(shift) < size:
            source = slice(max(shift, 0), min(size, size + shift))
            target = slice(max(-shift, 0), min(size, size - shift))
            moved[target] = self._counts[source]
        self._counts = moved
        self._base_m += shift * _BIN_M

    def _bands(self, sensor_z_m: float) -> HeightBands:
        assert self._base_m is not None
        config = self._config
        smooth = np.convolve(self._counts, np.ones(3), mode='same')
        centre = self._base_m + (np.arange(len(smooth)) + 0.5) * _BIN_M
        # Number of returns more than _BELOW_BINS below each bin; zero for the lowest bins.
        deeper = np.roll(np.cumsum(self._counts), _BELOW_BINS)
        deeper[:_BELOW_BINS] = 0.0
        nearer = centre > sensor_z_m - self._sensor_height_m + _NEARER_M
        is_floor = _planes(smooth, np.where(nearer, _NEARER_SHARE, _PLANE_SHARE))
        is_floor &= ~nearer | (deeper <= _BELOW_SHARE * self._counts.sum())
        below = np.flatnonzero(is_floor & (centre < sensor_z_m - _CLEAR_OF_SENSOR_M))
        if below.size:
            self._sensor_height_m = sensor_z_m - float(centre[_peak(self._counts, below[0])])
        floor = sensor_z_m - self._sensor_height_m
        lowest_ceiling = floor + LINTEL_HEIGHT_M + _CEILING_MARGIN_M
        is_above = centre > max(sensor_z_m, lowest_ceiling)
        above = np.flatnonzero(_planes(smooth[::-1], _PLANE_SHARE)[::-1] & is_above)
        ceiling = float(centre[_peak(self._counts, above[-1])]) if above.size else math.inf
        top = min(floor + LINTEL_TOP_M, ceiling - _CEILING_MARGIN_M)
        return HeightBands(
            floor + config.body_low_m,
            floor + config.body_high_m,
            floor + LINTEL_HEIGHT_M,
            top,
            min(ceiling - _CEILING_MARGIN_M, floor + _CARVE_TOP_M),
        )


def floor_and_ceiling(heights: NDArray[np.float64]) -> tuple[float | None, float | None]:
    """
    Return the lowest plane below the sensor and the highest above it; None if not seen.

    Parameters
    ----------
    heights : (P,) of returns, above the sensor [m]
    """
    count = round(2.0 * _REACH_M / _BIN_M)
    counts, edges = np.histogram(heights, count, (-_REACH_M, _REACH_M))
    centre = (edges[:-1] + edges[1:]) / 2.0
    smooth = np.convolve(counts.astype(np.float64), np.ones(3), mode='same')
    below = np.flatnonzero(_planes(smooth, _PLANE_SHARE) & (centre < -_CLEAR_OF_SENSOR_M))
    above = np.flatnonzero(
        _planes(smooth[::-1], _PLANE_SHARE)[::-1] & (centre > _CLEAR_OF_SENSOR_M)
    )
    floor = float(centre[_peak(counts, below[0])]) if below.size else None
    ceiling = float(centre[_peak(counts, above[-1])]) if above.size else None
    return floor, ceiling


def _planes(smooth: NDArray[np.float64], share: NDArray[np.float64] | float) -> NDArray[np.bool_]:
    """
    Return which bins hold a horizontal plane that exceeds the walls above it.

    Walls fill all visible heights evenly, so the lowest return is no floor. Empty bins are none.
    """
    beside = [np.roll(smooth, -step) for step in _WALL_BINS]
    least = np.maximum(share * smooth.sum() / 3.0, _STANDS_OUT * np.mean(beside, axis=0))
    return np.asarray((smooth > 0.0) & (smooth >= least))


def _peak(counts: NDArray[np.float64], start: int) -> int:
    """Return the fullest bin within 0.15 m of ``start``."""
    reach = 3
    low = max(0, start - reach)
    return low + int(np.argmax(counts[low : start + reach + 1]))
