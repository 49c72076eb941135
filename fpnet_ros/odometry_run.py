# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Identity of a run of the odometry, whose frame starts anew with every process.

DDS gives every publisher a unique identifier, and publishers number their messages. Together they
show, for any odometry, whether it went on while the localizer was down. Imports no ROS.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self


@dataclass(frozen=True)
class OdometryRun:
    """
    Publishers of the odometry, and the number of its newest message.

    ``publishers`` are the identifiers of all publishers on the topic, of a killed one for a while.
    ``number`` is 0 if the middleware does not number messages.
    """

    publishers: frozenset[str] = frozenset()
    number: int = 0

    def goes_on_from(self, saved: OdometryRun) -> bool | None:
        """Return whether this run continues a saved one; None if unknown."""
        if not (self.publishers and saved.publishers):
            return None
        return bool(self.publishers & saved.publishers) and self.number >= saved.number

    def as_text(self) -> str:
        """Return number and identifiers as words of one line."""
        return ' '.join([str(self.number), *sorted(self.publishers)])

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Return the run that :meth:`as_text` wrote; the unknown run for other texts."""
        number, *publishers = text.split() or ['']
        return cls(frozenset(publishers), int(number)) if number.isdecimal() else cls()
