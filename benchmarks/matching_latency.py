# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Time one match of the packaged network, and the network's throughput in batches.

Usage: ``python benchmarks/matching_latency.py [--plan-nodes 100] [--sub-nodes 30]``
"""

import argparse
import json
from statistics import median, quantiles
import time

import numpy as np
import torch

from fpnet_core.config import MatcherConfig
from fpnet_core.graphs import EDGE_FEATURES, NODE_FEATURES
from fpnet_core.io.weights import read_weights
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.models import batch_graphs, load_network
from fpnet_core.types import FEATURE_SCHEMA, Region, RegionGraph, RegionLabel

WARM_UP, REPEATS, BATCH = 5, 50, 32


def random_graph(rng: np.random.Generator, nodes: int, frame: str) -> RegionGraph:
    """Return a graph of the given size; its cost does not depend on what it means."""
    square = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]])
    regions = tuple(Region(i, RegionLabel.ROOM, square, np.zeros(2), 9.0) for i in range(nodes))
    pairs = rng.integers(0, nodes, (nodes, 2))
    edges = np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)
    node_feat = rng.standard_normal((nodes, NODE_FEATURES))
    edge_feat = np.ones((len(edges), EDGE_FEATURES))
    return RegionGraph(regions, edges, node_feat, edge_feat, frame)


def milliseconds(call, repeats: int) -> list[float]:
    """Return the durations of repeated calls after a warm-up."""
    times = []
    for index in range(WARM_UP + repeats):
        start = time.perf_counter()
        call()
        if index >= WARM_UP:
            times.append((time.perf_counter() - start) * 1e3)
    return times


def main() -> None:
    """Print the figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--plan-nodes', type=int, default=100)
    parser.add_argument('--sub-nodes', type=int, default=30)
    sizes = parser.parse_args()
    rng = np.random.default_rng(0)
    plan = random_graph(rng, sizes.plan_nodes, 'plan')
    sub = random_graph(rng, sizes.sub_nodes, 'submap')
    matcher = LearnedMatcher(MatcherConfig())
    single = milliseconds(lambda: matcher.match(plan, sub, 300.0), REPEATS)
    network = load_network(read_weights(None, FEATURE_SCHEMA))
    plans, subs = batch_graphs([plan] * BATCH), batch_graphs([sub] * BATCH)
    with torch.inference_mode():
        batched = milliseconds(lambda: network(plans, subs), REPEATS // 10)
    report = {
        'nodes': [sizes.plan_nodes, sizes.sub_nodes],
        'threads': torch.get_num_threads(),
        'match_ms_p50': median(single),
        'match_ms_p95': quantiles(single, n=20)[-1],
        'batched_pairs_per_s': BATCH * 1e3 / median(batched),
    }
    print(json.dumps(report, indent=1))


if __name__ == '__main__':
    main()
