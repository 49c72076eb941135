# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Time one match of the packaged network, its throughput in batches, and that of training.

Usage: ``python benchmarks/matching_latency.py [--plan-nodes 100] [--sub-nodes 30] [--threads 2]``

``match_ms`` is the whole call, network and consensus, with a plan that was matched before, as in
a localizer; ``cpu_ms`` is processor time, which other load on the machine changes less;
``busy_match_ms_p50`` is the same call while a process per core but one spins, as odometry does
on a robot. A match runs on one thread; ``--threads`` are those of batches and training.
"""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
import json
import multiprocessing
import os
from statistics import median, quantiles
import time

import numpy as np
import torch

from fpnet_core.config import MatcherConfig
from fpnet_core.graphs import edge_features, node_features
from fpnet_core.io.weights import read_weights
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.models import load_network
from fpnet_core.types import FEATURE_SCHEMA, Region, RegionGraph, RegionLabel
from fpnet_lab.training.config import LossConfig
from fpnet_lab.training.losses import supervised_loss

WARM_UP, REPEATS, BATCH = 5, 50, 32
SPACING_M = 4.0


def grid_graph(rng: np.random.Generator, nodes: int, frame: str, turn: float) -> RegionGraph:
    """Return rooms on a grid with a door to the next one each, half rooms and half doors."""
    regions, edges = [], []
    side = int(np.ceil(np.sqrt(nodes / 2)))
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    for index in range(nodes):
        number, is_door = divmod(index, 2)
        corner = SPACING_M * np.array(divmod(number, side), dtype=np.float64)
        size = np.array([0.9, 0.2]) if is_door else rng.uniform(2.0, 3.8, 2)
        corner = corner + (np.array([1.0, 3.9]) if is_door else 0.0)
        outline = corner + size * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        label = RegionLabel.DOOR if is_door else RegionLabel.ROOM
        outline = outline @ rotation.T
        regions.append(Region(index, label, outline, outline.mean(axis=0), float(size.prod())))
        if is_door:
            ends = (index - 1, index), (index, index + 1)
            edges += [pair for pair in ends if pair[1] < nodes]
    pairs = np.array(edges, dtype=np.int64)
    widths = np.full(len(pairs), 0.9)
    rows, links = node_features(regions), edge_features(regions, pairs, widths)
    return RegionGraph(tuple(regions), pairs, rows, links, frame)


def milliseconds(call, repeats: int) -> tuple[list[float], float]:
    """Return wall times of repeated calls after a warm-up, and the mean processor time."""
    times = []
    for _ in range(WARM_UP):
        call()
    cpu = time.process_time()
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append((time.perf_counter() - start) * 1e3)
    return times, (time.process_time() - cpu) / repeats * 1e3


def spin() -> None:
    """Keep a core busy until terminated."""
    while True:
        pass


@contextmanager
def busy_cores() -> Iterator[None]:
    """Keep every core but one busy."""
    context = multiprocessing.get_context('spawn')
    count = max(1, len(os.sched_getaffinity(0)) - 1)
    spinning = [context.Process(target=spin, daemon=True) for _ in range(count)]
    for process in spinning:
        process.start()
    try:
        yield
    finally:
        for process in spinning:
            process.terminate()
            process.join()


def training_rate(network, plans, subs) -> float:
    """Return pairs per second of a forward and backward pass."""
    network.requires_grad_(True)
    labels = torch.arange(subs.mask.shape[1]).expand(len(subs.mask), -1)

    def step() -> None:
        outputs = network.assignments(plans, subs)
        supervised_loss(outputs, labels, plans, LossConfig()).total.backward()

    times, _ = milliseconds(step, 2)
    return BATCH * 1e3 / median(times)


def main() -> None:
    """Print the figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--plan-nodes', type=int, default=100)
    parser.add_argument('--sub-nodes', type=int, default=30)
    parser.add_argument('--threads', type=int, default=2)
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    plan = grid_graph(np.random.default_rng(0), arguments.plan_nodes, 'plan', 0.0)
    sub = grid_graph(np.random.default_rng(0), arguments.sub_nodes, 'submap', 0.7)
    matcher = LearnedMatcher(MatcherConfig())
    wall, cpu = milliseconds(lambda: matcher.match(plan, sub, 300.0), REPEATS)
    with busy_cores():
        busy, _ = milliseconds(lambda: matcher.match(plan, sub, 300.0), REPEATS)
    _, network_cpu = milliseconds(lambda: matcher.likelihood(plan, sub), REPEATS)
    network = load_network(read_weights(None, FEATURE_SCHEMA))
    plans, subs = network.batch([plan] * BATCH), network.batch([sub] * BATCH)
    with torch.inference_mode():
        batched, _ = milliseconds(lambda: network(plans, subs), REPEATS // 10)
    report = {
        'nodes': [arguments.plan_nodes, arguments.sub_nodes],
        'threads': arguments.threads,
        'match_ms_p50': median(wall),
        'match_ms_p95': quantiles(wall, n=20)[-1],
        'busy_match_ms_p50': median(busy),
        'cpu_ms': cpu,
        'network_cpu_ms': network_cpu,
        'batched_pairs_per_s': BATCH * 1e3 / median(batched),
        'training_pairs_per_s': training_rate(network, plans, subs),
    }
    print(json.dumps(report, indent=1))


if __name__ == '__main__':
    main()
