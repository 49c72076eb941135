# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How much is gathered to learn from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self


@dataclass(frozen=True)
class Counts:
    """Numbers of samples by kind: the fields of a subclass, all int."""

    def scaled(self, share: float) -> Self:
        """Return so large a share of everything, at least one of each."""
        return type(self)(**{kind: max(1, round(share * n)) for kind, n in vars(self).items()})
