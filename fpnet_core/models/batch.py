# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Region graphs as padded arrays with masks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fpnet_core.models.arrays import Array


@dataclass(frozen=True, eq=False)
class GraphBatch:
    """
    ``B`` graphs padded to ``R`` nodes, as arrays or tensors.

    Parameters
    ----------
    node_feat : (B, R, D) float32, zeros in the padding
    adjacency : (B, R, R) float32, symmetric, 1 where a door opens into a room, else 0
    mask : (B, R) bool, True for real nodes
    """

    node_feat: Array
    adjacency: Array
    mask: Array


@dataclass(frozen=True, eq=False)
class PreparedBatch:
    """
    Results for ``B`` graphs that do not depend on the graphs they are matched with.

    ``encoded (B, R, width)`` are the nodes at the input of the first layer, ``relations (B,
    layers, heads, R, R)`` the attention logits within each graph, ``mask (B, R)`` is True for real
    nodes.
    """

    encoded: Array
    relations: Array
    mask: Array


def adjacency_matrix(edges: NDArray[np.int64], count: int) -> NDArray[np.float32]:
    """Return the symmetric ``(count, count)`` 0/1 matrix of undirected ``edges (E, 2)``."""
    matrix = np.zeros((count, count), dtype=np.float32)
    matrix[edges[:, 0], edges[:, 1]] = 1.0
    matrix[edges[:, 1], edges[:, 0]] = 1.0
    return matrix


def pad_graphs(
    node_feat: Sequence[NDArray[np.float32]], edges: Sequence[NDArray[np.int64]]
) -> GraphBatch:
    """
    Stack graphs given as ``node_feat (R_b, D)`` and ``edges (E_b, 2)`` into one batch of arrays.

    The padded size is that of the largest graph and at least one, so a batch of empty graphs has
    valid shapes and an all-False mask.
    """
    size = max((len(rows) for rows in node_feat), default=0) or 1
    count = len(node_feat)
    columns = node_feat[0].shape[1] if count else 0
    features = np.zeros((count, size, columns), dtype=np.float32)
    adjacency = np.zeros((count, size, size), dtype=np.float32)
    mask = np.zeros((count, size), dtype=np.bool_)
    for index, (rows, pairs) in enumerate(zip(node_feat, edges, strict=True)):
        features[index, : len(rows)] = rows
        adjacency[index, : len(rows), : len(rows)] = adjacency_matrix(pairs, len(rows))
        mask[index, : len(rows)] = True
    return GraphBatch(features, adjacency, mask)
