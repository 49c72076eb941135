# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Keypoints common to a plan and a map of part of its building: doors and room corners."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.frozen import freeze_field
from fpnet_core.types import Segmentation

# Chosen, not measured:
# Tolerance of the polygon that approximates a room's outline [m].
_STRAIGHT_M = 0.35
# Largest absolute cosine of a corner's angle: beyond it is a straight wall or a spike.
_LEAST_TURN = 0.5

_LEAST_WALL_M = 1.2
"""
Shorter walls make no corner: furniture, pillars, recesses, raster steps [m]. Fitted to the robot
maps of the development split (docs/sites.md, thousands of plans).
"""


class KeypointKind(IntEnum):
    """Kind of a keypoint; corners point into a room (convex) or around one (reflex)."""

    DOOR = 0
    CONVEX = 1
    REFLEX = 2


KINDS = len(KeypointKind)

PERIOD = np.array([np.pi, 2.0 * np.pi, 2.0 * np.pi], dtype=np.float32)
"""Physical, by kind: a door looks the same from both rooms, a corner opens to one side."""


@dataclass(frozen=True, eq=False)
class Keypoints:
    """
    Oriented points of a map, in true metres relative to its middle.

    ``xy (K, 2)`` [m], ``angle (K,)`` [rad] along a door's line or into a corner, and
    ``kind (K,)`` of :class:`KeypointKind`.
    """

    xy: NDArray[np.float32]
    angle: NDArray[np.float32]
    kind: NDArray[np.uint8]

    def __post_init__(self) -> None:
        """Check the shapes."""
        freeze_field(self, 'xy', np.float32, (None, 2))
        freeze_field(self, 'angle', np.float32, (len(self.xy),))
        freeze_field(self, 'kind', np.uint8, (len(self.xy),))

    def __len__(self) -> int:
        """Return the number of keypoints."""
        return len(self.xy)

    def scaled(self, factor: float) -> Keypoints:
        """Return the keypoints of a map that is ``factor`` times as large."""
        return Keypoints(self.xy * np.float32(factor), self.angle, self.kind)


def keypoints_of(segmentation: Segmentation, metres_per_unit: float = 1.0) -> Keypoints:
    """Return the doors and corners of a segmented map, possibly none."""
    rows = [*_doors(segmentation), *_corners(segmentation, metres_per_unit)]
    table = np.array(rows, dtype=np.float64).reshape(-1, 4)
    xy = (table[:, :2] - middle_of(segmentation)) * metres_per_unit
    kind = table[:, 3].astype(np.uint8)
    return Keypoints(xy.astype(np.float32), (table[:, 2] % PERIOD[kind]).astype(np.float32), kind)


def middle_of(segmentation: Segmentation) -> NDArray[np.float64]:
    """Return the keypoints' origin (2,) in nominal metres: the mean centroid of all regions."""
    centroids = [region.centroid for region in segmentation.regions]
    return np.asarray(np.mean(centroids, axis=0) if centroids else np.zeros(2))


def _doors(segmentation: Segmentation) -> Iterator[tuple[float, float, float, float]]:
    for portal in segmentation.portals:
        x, y = portal.ends.mean(axis=0).tolist()
        along = portal.ends[1] - portal.ends[0]
        yield x, y, float(np.arctan2(along[1], along[0])), float(KeypointKind.DOOR)


def _corners(
    segmentation: Segmentation, metres_per_unit: float
) -> Iterator[tuple[float, float, float, float]]:
    for room in segmentation.rooms:
        outline = room.polygon.astype(np.float32)[:, None]
        ring = cv2.approxPolyDP(outline, _STRAIGHT_M / metres_per_unit, True)[:, 0]
        yield from _corners_of(ring.astype(np.float64), _LEAST_WALL_M / metres_per_unit)


def _corners_of(
    ring: NDArray[np.float64], least: float
) -> Iterator[tuple[float, float, float, float]]:
    """Yield the corners of a counter-clockwise ``ring (V, 2)``; walls have ``least`` length."""
    back, ahead = np.roll(ring, 1, axis=0) - ring, np.roll(ring, -1, axis=0) - ring
    lengths = np.hypot(back[:, 0], back[:, 1]), np.hypot(ahead[:, 0], ahead[:, 1])
    back, ahead = (
        sides / np.maximum(length, 1e-9)[:, None]
        for sides, length in zip((back, ahead), lengths, strict=True)
    )
    is_corner = np.minimum(*lengths) >= least
    is_corner &= np.abs((back * ahead).sum(axis=1)) <= _LEAST_TURN
    cross = ahead[:, 0] * back[:, 1] - ahead[:, 1] * back[:, 0]
    into = back + ahead
    for index in np.flatnonzero(is_corner):
        kind = KeypointKind.CONVEX if cross[index] > 0.0 else KeypointKind.REFLEX
        angle = np.arctan2(into[index, 1], into[index, 0])
        yield float(ring[index, 0]), float(ring[index, 1]), float(angle), float(kind)
