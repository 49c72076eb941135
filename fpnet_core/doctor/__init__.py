# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks of a robot's topics, frames, clocks and sensors before localization, with fixes.

:func:`fpnet.doctor.examine.examine` runs all checks.
"""

from __future__ import annotations

from fpnet_core.doctor.findings import Finding, Problem
from fpnet_core.doctor.observed import Observed, Offer, Topic, Transform

__all__ = ['Finding', 'Observed', 'Offer', 'Problem', 'Topic', 'Transform']
