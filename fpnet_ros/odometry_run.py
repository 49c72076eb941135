# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Which run of the odometry a pose belongs to: its frame begins anew with every process.

DDS gives every publisher an identifier that no other one gets, and publishers number their
messages. Both together tell, of whatever odometry, whether it has gone on while the localizer was
away. Imports no ROS.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self


@dataclass(frozen=True)
class OdometryRun:
    """
    Who published the odometry, and how far.

    ``publishers`` are the identifiers of all on the topic; a killed one stays among them for a
    while. ``number`` is that of the newest message, 0 where the middleware does not count.
    """

    publishers: frozenset[str] = frozenset()
    number: int = 0

    def goes_on_from(self, saved: OdometryRun) -> bool | None:
        """Tell whether this is a saved run, later; None where nobody can tell."""
        if not (self.publishers and saved.publishers):
            return None
        return bool(self.publishers & saved.publishers) and self.number >= saved.number

    def as_text(self) -> str:
        """Return it as one word for each part."""
        return ' '.join([str(self.number), *sorted(self.publishers)])

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Return what :meth:`as_text` wrote; of other texts the unknown run."""
        number, *publishers = text.split() or ['']
        return cls(frozenset(publishers), int(number)) if number.isdecimal() else cls()
