# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Node and edge features of a region graph, schema 1 (paper, section III-C).

A node row holds 28 numbers, each shifted and scaled by a constant to about unit range:

======= =================== ==============================================================
columns name                value
======= =================== ==============================================================
0:2     ``POSITION``        centroid relative to the graph's centre, in ``POSITION_UNIT_M``
2       ``CONFIDENCE``      observed fraction x segmentation confidence
3:10    ``HU``              seven Hu moments, ``sign(h) log(1 + |h| / 0.01)``
10:25   ``FOURIER``         fifteen Fourier descriptors of the outline
25      ``AREA``            logarithm of the area
26:28   ``LABEL``           one-hot: door, room
======= =================== ==============================================================

The paper normalises positions by the image size. That discards the relative size of both maps and
makes positions depend on blank margins. Here both graphs keep nominal metres and only the origin
moves, to the area-weighted centroid of the regions, which needs no image. Rotation is not removed;
the network is trained under random rotations of both graphs.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.graphs.layout import POSITION, FeatureLayout
from fpnet_core.trajectory import lengths_along
from fpnet_core.types import Region, RegionLabel

Array = NDArray[np.float64]

CONFIDENCE = slice(2, 3)
HU = slice(3, 10)
FOURIER = slice(10, 25)
AREA = slice(25, 26)
LABEL = slice(26, 28)
NODE_FEATURES = 28  # given
EDGE_FEATURES = 3  # given

POSITION_UNIT_M = 20.0
"""Length that becomes 1 in node positions [m]; buildings span 30 to 100 m. Chosen."""

DISTANCE_UNIT_M = 5.0
"""Length that becomes 1 in edge distances [m]: about a door to its room's centre. Chosen."""

_HU_FLOOR = 0.01  # numerical
_FOURIER_FLOOR = 0.02  # numerical
KEPT_OUTLINES = 4096  # numerical: size of the cache of outline features
# Numerical: outline samples per region; the highest harmonic used is 8, so 64 oversamples four
# times.
_OUTLINE_SAMPLES = 64
# Harmonics whose magnitudes are kept: -8..-1 and 2..8. Harmonic 0 is the position and 1 the size.
_HARMONICS = np.array([*range(-8, 0), *range(2, 9)])

# Numerical: rounded means and spreads over rectangular, L-shaped and door-like outlines (aspect 1
# to 15). They only have to bring each column to about unit range and must not change within a
# schema.
_HU_SHIFT = np.array([3.4, 1.8, 0.1, 0.0, 0.0, 0.0, 0.0])
_HU_SCALE = np.array([0.5, 1.4, 0.4, 0.3, 0.2, 0.2, 0.2])  # numerical
# Numerical.
_FOURIER_SHIFT = np.array(
    [0.1, 0.5, 0.1, 0.8, 0.2, 1.3, 0.4, 2.8, 0.4, 1.7, 0.2, 0.9, 0.1, 0.6, 0.1]
)
# Numerical.
_FOURIER_SCALE = np.array(
    [0.2, 0.3, 0.3, 0.4, 0.5, 0.5, 0.8, 0.8, 0.8, 0.5, 0.5, 0.4, 0.3, 0.3, 0.2]
)
_AREA_SHIFT, _AREA_SCALE = 1.5, 2.0  # numerical
_FEATURE_LIMIT = 4.0  # numerical

# Given: the seventh Hu moment distinguishes mirror images. AREA is half a log area: a log length.
PAPER_LAYOUT = FeatureLayout(
    size=NODE_FEATURES,
    odd=(0, HU.stop - 1),
    log_lengths=(AREA.start,),
    noisy=slice(HU.start, AREA.stop),
)


def graph_centre(regions: Sequence[Region]) -> Array:
    """Return the area-weighted centroid ``(2,)`` of the regions [m]; zeros without regions."""
    if not regions:
        return np.zeros(2)
    area = np.array([region.area_m2 for region in regions])
    centroid = np.array([region.centroid for region in regions])
    centre: Array = area @ centroid / area.sum()
    return centre


def node_features(regions: Sequence[Region]) -> NDArray[np.float32]:
    """
    Return the feature rows ``(R, 28) float32`` of regions that share a metric frame.

    Invariant to translation of the frame; ``HU``, ``FOURIER`` and ``AREA`` also to rotation, the
    first two also to scale. No regions give ``(0, 28)``.
    """
    rows = np.zeros((len(regions), NODE_FEATURES))
    if not regions:
        return rows.astype(np.float32)
    centroid = np.array([region.centroid for region in regions])
    rows[:, POSITION] = (centroid - graph_centre(regions)) / POSITION_UNIT_M
    for row, region in zip(rows, regions, strict=True):
        row[CONFIDENCE] = region.observed_fraction * region.confidence
        row[HU], row[FOURIER] = _shape_features(region.polygon.tobytes())
        row[AREA] = (np.log(region.area_m2) - _AREA_SHIFT) / _AREA_SCALE
        row[LABEL] = (region.label is RegionLabel.DOOR, region.label is RegionLabel.ROOM)
    shape = slice(HU.start, AREA.stop)
    rows[:, shape] = rows[:, shape].clip(-_FEATURE_LIMIT, _FEATURE_LIMIT)
    return rows.astype(np.float32)


@lru_cache(maxsize=KEPT_OUTLINES)
def _shape_features(polygon: bytes) -> tuple[Array, Array]:
    """Return an outline's scaled HU and FOURIER features; cached, since rooms recur."""
    outline = np.frombuffer(polygon, dtype=np.float64).reshape(-1, 2)
    hu = (hu_moments(outline) - _HU_SHIFT) / _HU_SCALE
    return hu, (fourier_descriptors(outline) - _FOURIER_SHIFT) / _FOURIER_SCALE


def edge_features(
    regions: Sequence[Region], edges: NDArray[np.int64], width_m: Sequence[float]
) -> NDArray[np.float32]:
    """
    Return ``(E, 3) float32``: connectivity (1), centroid distance, opening width.

    Lengths are in ``DISTANCE_UNIT_M``. Pairs that are not in ``edges (E, 2)`` have connectivity
    0, as in the paper; ``width_m`` holds one opening width per edge [m].
    """
    if len(edges) == 0:
        return np.zeros((0, EDGE_FEATURES), dtype=np.float32)
    centroid = np.array([region.centroid for region in regions])
    distance_m = np.linalg.norm(centroid[edges[:, 0]] - centroid[edges[:, 1]], axis=1)
    lengths = np.stack([distance_m, np.asarray(width_m)], axis=1) / DISTANCE_UNIT_M
    return np.concatenate([np.ones((len(edges), 1)), lengths], axis=1).astype(np.float32)


def hu_moments(polygon: Array) -> Array:
    """
    Return ``sign(h) log(1 + |h| / 0.01)`` of the seven Hu moments of ``polygon (V, 2)``.

    This compression separates the first moments, which describe the elongation, and damps the
    higher ones, which are mostly noise; it retrieves complete rooms better than log10.
    """
    moments: Any = cv2.moments((polygon - polygon.mean(axis=0)).astype(np.float32))
    hu = np.asarray(cv2.HuMoments(moments), dtype=np.float64).ravel()
    compressed: Array = np.sign(hu) * np.log1p(np.abs(hu) / _HU_FLOOR)
    return compressed


def fourier_descriptors(polygon: Array) -> Array:
    """
    Return fifteen compressed Fourier magnitudes of the outline ``polygon (V, 2)``.

    The closed outline is sampled evenly by arc length as complex numbers. The magnitudes of the
    harmonics -8..-1 and 2..8 over that of harmonic 1 are invariant to translation, rotation, scale
    and the starting vertex. An outline without length gives zeros.
    """
    samples = resample_outline(polygon, _OUTLINE_SAMPLES)
    magnitude = np.abs(np.fft.fft(samples[:, 0] + 1j * samples[:, 1]))
    # Outlines must be counter-clockwise; a clockwise one has its size in harmonic -1.
    size = magnitude[1]
    if size <= np.finfo(np.float64).eps:
        return np.zeros(len(_HARMONICS))
    compressed: Array = np.log1p(magnitude[_HARMONICS] / size / _FOURIER_FLOOR)
    return compressed


def resample_outline(polygon: Array, count: int) -> Array:
    """Return ``(count, 2)`` points spaced evenly along the closed outline ``polygon (V, 2)``."""
    closed = np.concatenate([polygon, polygon[:1]])
    along = lengths_along(closed)
    at = np.arange(count) * along[-1] / count
    return np.stack([np.interp(at, along, closed[:, axis]) for axis in range(2)], axis=1)
