# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the baseline localizers answer."""

from __future__ import annotations

from dataclasses import dataclass, field

from fpnet_core.geometry import Placement


@dataclass(frozen=True, eq=False)
class Answer(Placement):
    """
    Where a baseline puts the submap, and whether it stands for that.

    Plan metres are the nominal ones; ``score`` in [0, 1] is the method's own confidence.
    """

    is_accepted: bool = field(kw_only=True)
