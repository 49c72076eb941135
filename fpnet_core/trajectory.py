# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trajectories of planar poses."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fpnet_core.geometry import SE2, Affine2D

_MAX_STAMP_GAP_NS = 200_000_000  # poses further away in time are not used; chosen

Array = NDArray[np.float64]


def lengths_along(points: Array) -> Array:
    """Return the length (S,) of the path through ``points (S, D)`` up to each point."""
    steps = np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=1)
    return np.asarray(np.cumsum(steps))


def path_length(points: Array) -> float:
    """Return the length of the path through ``points (S, D)``, 0 without points."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


@dataclass(frozen=True, eq=False)
class PlanarTrajectory:
    """Planar poses in one frame: ``stamps_ns (S,)`` ascending, ``xy (S, 2)`` [m], ``yaw (S,)``."""

    stamps_ns: NDArray[np.int64]
    xy: Array
    yaw: Array

    def __len__(self) -> int:
        """Count the poses."""
        return len(self.stamps_ns)

    @classmethod
    def from_transforms(cls, stamps_ns: ArrayLike, T_frame_body: ArrayLike) -> PlanarTrajectory:
        """Project rigid transforms ``(S, 4, 4)`` onto the ground plane."""
        poses = np.asarray(T_frame_body, dtype=np.float64).reshape(-1, 4, 4)
        yaw = np.arctan2(poses[:, 1, 0], poses[:, 0, 0])
        return cls(np.asarray(stamps_ns, dtype=np.int64), poses[:, :2, 3], yaw)

    @classmethod
    def of(cls, poses: Iterable[tuple[int, SE2]]) -> PlanarTrajectory:
        """Return the trajectory of stamps and poses; it may be empty."""
        each = list(poses)
        return cls(
            np.array([stamp_ns for stamp_ns, _ in each], dtype=np.int64),
            np.array([T.translation for _, T in each]).reshape(-1, 2),
            np.array([T.yaw for _, T in each]),
        )

    @classmethod
    def empty(cls) -> PlanarTrajectory:
        """Return a trajectory without poses."""
        return cls.of(())

    def take(self, chosen: NDArray[Any]) -> PlanarTrajectory:
        """Return the ``chosen`` poses, a mask (S,) or indices."""
        return PlanarTrajectory(self.stamps_ns[chosen], self.xy[chosen], self.yaw[chosen])

    def joined(self, other: PlanarTrajectory) -> PlanarTrajectory:
        """Return these poses followed by those of ``other``."""
        return PlanarTrajectory(
            np.concatenate([self.stamps_ns, other.stamps_ns]),
            np.concatenate([self.xy, other.xy]),
            np.concatenate([self.yaw, other.yaw]),
        )

    def path_length_m(self, until_ns: int | None = None) -> float:
        """Return the length of the path [m], up to and including ``until_ns``."""
        return path_length(self.xy if until_ns is None else self.xy[self.stamps_ns <= until_ns])

    def mapped(self, A: Affine2D) -> PlanarTrajectory:
        """Return the same poses in another frame."""
        heading = np.stack([np.cos(self.yaw), np.sin(self.yaw)], axis=-1) @ A.linear.T
        return PlanarTrajectory(
            self.stamps_ns, A.apply(self.xy), np.arctan2(heading[:, 1], heading[:, 0])
        )

    def at(self, stamps_ns: NDArray[np.int64]) -> tuple[PlanarTrajectory, NDArray[np.bool_]]:
        """Return the pose nearest in time to each stamp, and whether it is near enough to use."""
        after = np.clip(np.searchsorted(self.stamps_ns, stamps_ns), 1, len(self) - 1)
        before = after - 1
        nearer = np.where(
            stamps_ns - self.stamps_ns[before] <= self.stamps_ns[after] - stamps_ns, before, after
        )
        gap = np.abs(self.stamps_ns[nearer] - stamps_ns)
        return self.take(nearer), gap <= _MAX_STAMP_GAP_NS
