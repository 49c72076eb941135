# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The matching networks on padded tensors; importing this package loads torch."""

from fpnet_core.models.batch import GraphBatch, pad_graphs
from fpnet_core.models.config import EdgeMapping, InvariantConfig, NetworkConfig, PaperConfig
from fpnet_core.models.invariant import InvariantNetwork, double_softmax
from fpnet_core.models.loading import (
    load_network,
    load_tensors,
    make_network,
    network_type,
)
from fpnet_core.models.network import RegionNetwork
from fpnet_core.models.paper import PaperNetwork
from fpnet_core.models.sinkhorn import log_assignment

__all__ = [
    'EdgeMapping',
    'GraphBatch',
    'InvariantConfig',
    'InvariantNetwork',
    'NetworkConfig',
    'PaperConfig',
    'PaperNetwork',
    'RegionNetwork',
    'double_softmax',
    'load_network',
    'load_tensors',
    'log_assignment',
    'make_network',
    'network_type',
    'pad_graphs',
]
