# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a robot's wiring, in words that say what to do."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Problem(StrEnum):
    """Kinds of what can be wrong; each has its paragraph in notes/doctor.md."""

    TOPIC = 'topic missing'
    SILENT = 'nothing comes'
    QOS = 'QoS does not match'
    FRAME = 'frame unknown'
    PARENTS = 'frame with two parents'
    LOOP = 'loop in TF'
    CLOCK_JUMP = 'clock jumps'
    OTHER_CLOCK = 'stamps from another clock'
    SPARSE = 'poses too far apart'
    RARE = 'scans too rare for odometry'
    LAG = 'stamps at the wrong end of the sweep'
    FORMAT = 'scans unreadable'
    BLIND = 'scans without returns'
    UNIT = 'ranges in another unit'
    POINT_TIMES = 'no time per point'
    UPSIDE_DOWN = 'sensor upside down'
    TILTED = 'sensor tilted'
    HEIGHT = 'sensor at the wrong height'
    ODOMETRY = 'odometry disagrees with the scans'
    GYRO = 'gyroscope disagrees with the scans'
    REGISTRATION = 'scans lose their way'


@dataclass(frozen=True)
class Finding:
    """
    One thing that is wrong.

    ``where`` is a topic or frame, ``evidence`` what was seen, in figures, ``next`` what to do.
    """

    problem: Problem
    where: str
    evidence: str
    next: str

    @property
    def said(self) -> str:
        """Return all but what to do, in one line."""
        return f'{self.problem.value} ({self.where}): {self.evidence}'

    def as_json(self) -> dict[str, str]:
        """Return a mapping of plain values."""
        return {
            'problem': self.problem.value,
            'where': self.where,
            'evidence': self.evidence,
            'next': self.next,
        }
