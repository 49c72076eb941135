# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Result of the baseline localizers."""

from __future__ import annotations

from dataclasses import dataclass, field

from fpnet_core.geometry import Placement


@dataclass(frozen=True, eq=False)
class Answer(Placement):
    """
    Placement of the submap by a baseline, and whether the method accepts it.

    Plan metres are nominal; ``score`` in [0, 1] is the method's own confidence.
    """

    is_accepted: bool = field(kw_only=True)
