# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Localization over time: updates, hypotheses and the decision to publish a pose."""

from fpnet_core.config import FpnetConfig
from fpnet_core.localizer.global_localizer import GlobalLocalizer
from fpnet_core.localizer.localizer import Localizer
from fpnet_core.localizer.maps import MapMatch, MapMatchStatus, match_maps
from fpnet_core.localizer.prepared_maps import prepare_plan
from fpnet_core.localizer.replay import Replay, ReplayResult, replay
from fpnet_core.localizer.storeys import StoreyPlan
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.scoring import PlacementScorer

__all__ = [
    'GlobalLocalizer',
    'Localizer',
    'MapMatch',
    'MapMatchStatus',
    'Replay',
    'ReplayResult',
    'StoreyPlan',
    'create_global_localizer',
    'create_localizer',
    'match_maps',
    'prepare_plan',
    'replay',
]


def create_localizer(config: FpnetConfig) -> Localizer:
    """
    Return a localizer with the learned matcher and its packaged or given weights.

    Raises
    ------
    WeightsError
        If the weights are missing, corrupt, or made for another feature schema.
    """
    return Localizer(config, LearnedMatcher(config.matcher))


def create_global_localizer(config: FpnetConfig) -> GlobalLocalizer:
    """
    Return a global localizer with the learned matcher and scorer, packaged or given weights.

    Raises
    ------
    WeightsError
        If the weights are missing, corrupt, or made for another schema.
    """
    return GlobalLocalizer(
        LearnedMatcher(config.matcher), PlacementScorer.configured(config.localizer), config
    )
