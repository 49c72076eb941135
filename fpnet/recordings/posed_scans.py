# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Scans with poses from a separate file, for example from KISS-ICP."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fpnet.recordings.trajectories import Trajectory
from fpnet_core.errors import OdometryError
from fpnet_core.io.scans import Scan, ScanSource
from fpnet_core.stamps import NS_PER_S

_SAME_TIME_NS = 50_000_000  # chosen: half a sweep; KISS-ICP writes times of recording


@dataclass(frozen=True, eq=False)
class PosedScans:
    """
    The scans of ``source`` with their poses replaced by ``poses``.

    If there are as many poses as scans, they are paired in order and times are ignored: KISS-ICP
    numbers the scans of a folder and rounds the times of a bag. Otherwise each scan gets the pose
    nearest in time, and scans without a pose within 50 ms are skipped. Sweeps with point times
    are deskewed with these poses, except for the first one.

    Raises
    ------
    OdometryError
        If the numbers differ and no scan has a pose near in time.
    """

    source: ScanSource
    poses: Trajectory

    def __post_init__(self) -> None:
        """Check that at least one scan has a pose."""
        if len(self.poses) == len(self.source):
            return
        if next(iter(self), None) is None:
            raise OdometryError(
                f'{len(self.poses)} poses for {len(self.source)} scans, none at the time of a '
                'scan; pass the poses of this recording'
            )

    @property
    def kind(self) -> Literal['bag', 'carmen', 'folder']:
        """Storage format of the scans."""
        return self.source.kind

    @property
    def has_poses(self) -> bool:
        """Always true."""
        return True

    def __len__(self) -> int:
        """Return the number of scans of the source."""
        return len(self.source)

    def __iter__(self) -> Iterator[Scan]:
        """Yield the scans that have a pose, deskewed."""
        last_ns, T_last = 0, None
        for scan in self._posed():
            now_ns, T_now = scan.stamp_ns, scan.T_odom_sensor
            assert T_now is not None
            if T_last is None or now_ns <= last_ns:
                yield scan
            else:
                seconds = (now_ns - last_ns) / NS_PER_S
                yield scan.without_motion(np.linalg.inv(T_last) @ T_now, seconds)
            last_ns, T_last = now_ns, T_now

    def _posed(self) -> Iterator[Scan]:
        if len(self.poses) == len(self.source):
            for scan, T_odom_sensor in zip(self.source, self.poses.T_frame_body, strict=False):
                yield replace(scan, T_odom_sensor=T_odom_sensor)
            return
        order = np.argsort(self.poses.stamps_ns, kind='stable')
        stamps = self.poses.stamps_ns[order]
        for scan in self.source:
            after = int(np.searchsorted(stamps, scan.stamp_ns))
            near = [k for k in (after - 1, after) if 0 <= k < len(stamps)]
            index = min(near, key=lambda k: abs(int(stamps[k]) - scan.stamp_ns))
            if abs(int(stamps[index]) - scan.stamp_ns) <= _SAME_TIME_NS:
                yield replace(scan, T_odom_sensor=self.poses.T_frame_body[order[index]])
