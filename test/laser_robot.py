# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot with planar scanners that drives through a room, and what their drivers report."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from fpnet_core.io.laserscan import LaserReadings

PERIOD_NS = 100_000_000
START_NS = 1_700_000_000_000_000_000
# Corners of the room [m], counter-clockwise; the robot starts at the origin. No two views alike.
CORNERS = [(-3, -2), (4, -2), (4, -0.5), (8, -0.5), (8, 4), (1, 4), (1, 5.5), (-3, 5.5)]
POST = [(2.5, 2.6), (2.9, 2.6), (2.9, 3.1), (2.5, 3.1)]
_WALLS = np.array(
    [
        (outline[k], outline[(k + 1) % len(outline)])
        for outline in (CORNERS, POST)
        for k in range(len(outline))
    ],
    dtype=np.float64,
)


def place(x, y, z, *, roll=0.0, pitch=0.0, yaw=0.0):
    """Return a rigid transform (4, 4)."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler('xyz', [roll, pitch, yaw]).as_matrix()
    T[:3, 3] = x, y, z
    return T


def base_at(stamp_ns):
    """Return ``T_room_base (4, 4)``: from rest to 0.8 m/s in 2 s, turning at up to 40 deg/s."""
    s = (stamp_ns - START_NS) / 1e9
    return place(0.2 * s**2, 0.03 * s**2, 0.0, yaw=0.2 * (1.0 - np.cos(3.5 * s)))


@dataclass(frozen=True, eq=False)
class Scanner:
    """A planar scanner: where it is, how far it turns in its time, and when it begins."""

    frame: str
    T_base_laser: np.ndarray
    turn_rad: float = 1.5 * np.pi
    rays: int = 360
    offset_ns: int = 0

    def readings(self, index: int, rng: np.random.Generator) -> tuple[int, LaserReadings]:
        """Return the stamp of a sweep's first ray and its ranges, each from where it was then."""
        first_ns = START_NS + index * PERIOD_NS + self.offset_ns
        step_rad = self.turn_rad / self.rays
        step_ns = round(PERIOD_NS * step_rad / (2.0 * np.pi))
        angles = -0.5 * self.turn_rad + step_rad * np.arange(self.rays)
        ranges = np.empty(self.rays)
        for ray, angle in enumerate(angles):
            T = base_at(first_ns + ray * step_ns) @ self.T_base_laser
            direction = T[:3, :3] @ [np.cos(angle), np.sin(angle), 0.0]
            ranges[ray] = _distance(T[:2, 3], direction[:2])
        ranges += rng.normal(0.0, 0.005, self.rays)
        ranges[rng.random(self.rays) < 0.02] = np.inf
        readings = LaserReadings(
            float(angles[0]), step_rad, step_ns / 1e9, 0.05, 30.0, ranges.astype(np.float32)
        )
        return first_ns, readings


FRONT = Scanner('front_laser', place(0.35, 0.1, 0.2, yaw=0.3))
REAR = Scanner('rear_laser', place(-0.3, -0.15, 0.25, roll=np.pi, yaw=2.9), offset_ns=30_000_000)
"""The rear one hangs upside down, and begins its sweeps a third of a turn later."""


def _distance(origin, direction):
    """Return how far the nearest wall is along a ray, by the segments it crosses."""
    a, along = _WALLS[:, 0] - origin, _WALLS[:, 1] - _WALLS[:, 0]
    across = direction[0] * along[:, 1] - direction[1] * along[:, 0]
    with np.errstate(divide='ignore', invalid='ignore'):
        far = (a[:, 0] * along[:, 1] - a[:, 1] * along[:, 0]) / across
        share = (a[:, 0] * direction[1] - a[:, 1] * direction[0]) / across
    return far[(far > 0.0) & (share >= 0.0) & (share <= 1.0)].min()


def distance_to_walls(xy):
    """Return the distance of points (P, 2), in the room's frame, to the nearest wall."""
    start, along = _WALLS[:, 0], _WALLS[:, 1] - _WALLS[:, 0]
    offset = xy[:, None] - start
    share = np.clip((offset * along).sum(-1) / (along**2).sum(-1), 0.0, 1.0)
    return np.linalg.norm(offset - share[..., None] * along, axis=-1).min(axis=1)
