# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Region matchers by name, for the command line and the benchmarks."""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources
from pathlib import Path

from fpnet_core.config import MatcherConfig
from fpnet_core.matching import RegionMatcher
from fpnet_lab.baselines.bounding_boxes import BoundingBoxMatcher
from fpnet_lab.baselines.nearest_neighbor import NearestNeighborMatcher

# The imports inside load torch or pygmtools, which the other matchers do without.


def _learned(config: MatcherConfig, settle: bool = True) -> RegionMatcher:
    from fpnet_core.matching.learned import LearnedMatcher

    return LearnedMatcher(config, settle)


def _network_alone(config: MatcherConfig) -> RegionMatcher:
    return _learned(config, settle=False)


def _paper(config: MatcherConfig) -> RegionMatcher:
    return _learned(config.model_copy(update={'weights': _packaged('paper')}))


def _superglue(config: MatcherConfig) -> RegionMatcher:
    return _learned(config.model_copy(update={'weights': _packaged('superglue')}))


def _packaged(name: str) -> str:
    return str(Path(str(resources.files('fpnet_core.weights'))) / f'{name}.safetensors')


def _rrwm(config: MatcherConfig) -> RegionMatcher:
    from fpnet_lab.baselines.graph_matching import rrwm

    return rrwm(config)


def _spectral(config: MatcherConfig) -> RegionMatcher:
    from fpnet_lab.baselines.graph_matching import spectral

    return spectral(config)


MATCHERS: dict[str, Callable[[MatcherConfig], RegionMatcher]] = {
    'fpnet': _learned,
    'fpnet_network': _network_alone,
    'paper': _paper,
    'superglue': _superglue,
    'nearest_neighbor': NearestNeighborMatcher,
    'ombb': BoundingBoxMatcher,
    'rrwm': _rrwm,
    'spectral': _spectral,
}
"""Factories by name; one whose weights are not packaged raises WeightsError."""

__all__ = ['MATCHERS', 'BoundingBoxMatcher', 'NearestNeighborMatcher']
