# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cadence, hypotheses over time, and what may be claimed."""

from fpnet_core.config import FpnetConfig
from fpnet_core.localizer.localizer import Localizer
from fpnet_core.localizer.sides import MapSide, prepare_plan
from fpnet_core.matching import LearnedMatcher

__all__ = ['Localizer', 'MapSide', 'create_localizer', 'prepare_plan']


def create_localizer(config: FpnetConfig) -> Localizer:
    """
    Return a localizer with the configured matcher and its packaged or given weights.

    Raises
    ------
    WeightsError
        If the weights are missing, corrupt, or made for another feature schema.
    """
    return Localizer(config, LearnedMatcher(config.matcher))
