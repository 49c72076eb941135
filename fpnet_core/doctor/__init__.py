# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What keeps a robot from being found before any floorplan is looked at, and what to do.

:func:`fpnet.doctor.examine.examine` makes every check.
"""

from __future__ import annotations

from fpnet_core.doctor.findings import Finding, Problem
from fpnet_core.doctor.observed import Observed, Offer, Topic, Transform

__all__ = ['Finding', 'Observed', 'Offer', 'Problem', 'Topic', 'Transform']
