# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Region matchers by name, for the command line and the benchmarks."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import resources

from fpnet_core.config import MatcherConfig
from fpnet_core.matching import RegionMatcher
from fpnet_lab.baselines.bounding_boxes import BoundingBoxMatcher
from fpnet_lab.baselines.nearest_neighbor import NearestNeighborMatcher

# The local imports below load torch or pygmtools, which the other matchers do not need.


def _learned(config: MatcherConfig, settle: bool = True) -> RegionMatcher:
    from fpnet_core.matching.learned import LearnedMatcher

    return LearnedMatcher(config, settle)


def _network_alone(config: MatcherConfig) -> RegionMatcher:
    return _learned(config, settle=False)


def _with_weights(name: str, config: MatcherConfig) -> RegionMatcher:
    weights = str(resources.files('fpnet_core.weights') / f'{name}.safetensors')
    return _learned(config.model_copy(update={'weights': weights}))


def _solved_by(solver: str, config: MatcherConfig) -> RegionMatcher:
    from fpnet_lab.baselines.graph_matching import GraphMatchingMatcher

    del config  # unused: all matcher factories share one signature
    return GraphMatchingMatcher(solver)


MATCHERS: dict[str, Callable[[MatcherConfig], RegionMatcher]] = {
    'fpnet': _learned,
    'fpnet_network': _network_alone,
    'paper': partial(_with_weights, 'paper'),
    'superglue': partial(_with_weights, 'superglue'),
    'nearest_neighbor': NearestNeighborMatcher,
    'ombb': BoundingBoxMatcher,
    'rrwm': partial(_solved_by, 'rrwm'),
    'spectral': partial(_solved_by, 'sm'),
}
"""Factories by name; a factory raises WeightsError if its weights are not packaged."""

__all__ = ['MATCHERS', 'BoundingBoxMatcher', 'NearestNeighborMatcher']
