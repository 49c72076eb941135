# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Inference with networks of tensors; importing this imports torch."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import torch

from fpnet_core.models.batch import GraphBatch
from fpnet_core.models.network import RegionNetwork
from fpnet_core.types import RegionGraph


@dataclass(frozen=True, eq=False)
class OnTensors:
    """Network of tensors, applied to one pair of graphs."""

    network: RegionNetwork

    def prepared(self, graph: RegionGraph) -> GraphBatch:
        """Return the graph as a batch."""
        return self.network.batch([graph])

    def likelihood(self, plan: GraphBatch, sub: GraphBatch) -> NDArray[np.float64]:
        """Return the assignment ``(M, N)``; neither graph is empty."""
        with _one_thread(), torch.inference_mode():
            log_assignment = self.network(plan, sub)
            found: NDArray[np.float64] = log_assignment[0, :-1, :-1].double().exp().numpy()
        return found


@contextmanager
def _one_thread() -> Iterator[None]:
    """
    Run tensor operations on the calling thread.

    The graphs are too small to gain from several threads, and a thread pool waits at every
    operation for its slowest thread: beside other busy programs a match took many times as long.
    """
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
