# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Throughput of the simulator for pairs, plans and scans, without start-up and compilation."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
import multiprocessing
import os
from pathlib import Path
import platform
import tempfile
import time
from typing import Any

import numpy as np

from fpnet_lab.pool import START_METHOD
from fpnet_lab.provenance import processor
from fpnet_lab.sim.buildings.building import extrude
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.lidars.lidar import LidarSimulator
from fpnet_lab.sim.lidars.sensors import SENSORS
from fpnet_lab.sim.pairs.writing import BLOCK_PAIRS, write_pairs
from fpnet_lab.sim.plans import generate_plan

ROOMS = (26, 34)
"""Bounds of the number of rooms of a storey: about 30. Chosen."""

SENSOR = 'beams32'
# Chosen, not measured:
SENSOR_HEIGHT_M = 1.0
DRAWING_CELL_M = 0.05

_CHUNK_PLANS = 5  # numerical
_WARM_UP_SCANS = 3  # numerical


def simulator_throughput(
    seed: int,
    workers: int = 2,
    blocks: int = 12,
    plans: int = 100,
    scans: int = 100,
    on_pairs: Callable[[int], None] | None = None,
) -> dict[str, Any]:
    """
    Measure the simulator on storeys of about 30 rooms.

    Parameters
    ----------
    seed : seed of the storeys
    workers : number of processes for pairs and plans, of threads for scans
    blocks : number of blocks of pairs to write; the first block of each worker is not timed
    plans, scans : number of timed plans and scans
    on_pairs : callback that gets the number of pairs after each block

    Returns
    -------
    ``pairs_per_s`` (2D tour, both segmentations, features, labels, file), ``plans_per_s``
    (generated and drawn), ``scans_per_s`` (a 32-beam sweep in a furnished building), the
    sample sizes and a description of the machine.
    """
    return {
        'pairs_per_s': _pairs_per_s(seed, workers, blocks, on_pairs),
        'plans_per_s': _plans_per_s(seed, workers, plans),
        'scans_per_s': _scans_per_s(seed, workers, scans),
        'rooms': list(ROOMS),
        'pairs': (blocks - workers) * BLOCK_PAIRS,
        'plans': plans,
        'scans': scans,
        'sensor': SENSOR,
        'workers': workers,
        'cores': os.cpu_count(),
        'processor': processor(),
        'python': platform.python_version(),
    }


def _pairs_per_s(
    seed: int, workers: int, blocks: int, on_pairs: Callable[[int], None] | None
) -> float:
    finished: list[float] = []

    def note(count: int) -> None:
        if count:
            finished.append(time.perf_counter())
            if on_pairs is not None:
                on_pairs(count)

    config = SimConfig(min_rooms=ROOMS[0], max_rooms=ROOMS[1])
    with tempfile.TemporaryDirectory() as folder:
        count = blocks * BLOCK_PAIRS
        write_pairs(Path(folder), seed, count, workers=workers, config=config, on_pairs=note)
    timed = len(finished) - workers
    return timed * BLOCK_PAIRS / (finished[-1] - finished[workers - 1])


def _plans_per_s(seed: int, workers: int, count: int) -> float:
    chunks = -(-count // _CHUNK_PLANS)
    context = multiprocessing.get_context(START_METHOD)
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        list(pool.map(_draw_plans, [(seed, -1 - i) for i in range(workers)]))
        start = time.perf_counter()
        drawn = sum(pool.map(_draw_plans, [(seed, i) for i in range(chunks)]))
        return drawn / (time.perf_counter() - start)


def _draw_plans(chunk: tuple[int, int]) -> int:
    """Generate and draw the plans of one chunk and return their number."""
    seed, number = chunk
    rng = np.random.default_rng([seed, abs(number), int(number < 0)])
    for _ in range(_CHUNK_PLANS):
        plan = generate_plan(rng, min_rooms=ROOMS[0], max_rooms=ROOMS[1])
        render_plan(plan, DRAWING_CELL_M)
    return _CHUNK_PLANS


def _scans_per_s(seed: int, threads: int, count: int) -> float:
    rng = np.random.default_rng(seed)
    plan = generate_plan(rng, min_rooms=ROOMS[0], max_rooms=ROOMS[1])
    model = SENSORS[SENSOR]
    lidar = LidarSimulator(extrude(plan, rng), model, threads)
    columns = len(model.column_times_s)
    R = np.broadcast_to(np.eye(3), (columns, 3, 3))
    rooms = rng.integers(len(plan.rooms), size=_WARM_UP_SCANS + count)
    for i, room in enumerate(rooms.tolist()):
        if i == _WARM_UP_SCANS:
            start = time.perf_counter()
        place = np.append(plan.rooms[room].polygon.mean(axis=0), SENSOR_HEIGHT_M)
        lidar.sweep(R, np.broadcast_to(place, (columns, 3)), 0.1 * i, rng)
    return count / (time.perf_counter() - start)
