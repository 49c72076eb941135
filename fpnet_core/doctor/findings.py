# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Findings of the doctor: faults of a robot's configuration, with fixes."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Problem(StrEnum):
    """Kinds of faults; each has a row in notes/doctor.md."""

    TOPIC = 'topic missing'
    SILENT = 'no messages'
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
    REGISTRATION = 'scan registration fails'


@dataclass(frozen=True)
class Finding:
    """
    A fault.

    ``where`` is a topic or frame, ``evidence`` the measurement, ``next`` the fix.
    """

    problem: Problem
    where: str
    evidence: str
    next: str

    @property
    def said(self) -> str:
        """The finding in one line, without the fix."""
        return f'{self.problem.value} ({self.where}): {self.evidence}'

    def as_json(self) -> dict[str, str]:
        """Return a mapping of plain values."""
        return {
            'problem': self.problem.value,
            'where': self.where,
            'evidence': self.evidence,
            'next': self.next,
        }
