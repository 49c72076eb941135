# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The matching network on padded tensors; importing this package loads torch."""

from fpnet_core.models.batch import GraphBatch, batch_graphs, pad_graphs
from fpnet_core.models.config import EdgeMapping, NetworkConfig
from fpnet_core.models.loading import load_network, load_tensors
from fpnet_core.models.matcher import MatchingNetwork
from fpnet_core.models.sinkhorn import log_assignment

__all__ = [
    'EdgeMapping',
    'GraphBatch',
    'MatchingNetwork',
    'NetworkConfig',
    'batch_graphs',
    'load_network',
    'load_tensors',
    'log_assignment',
    'pad_graphs',
]
