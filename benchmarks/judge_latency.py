# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What does it cost to judge a tick's placements?

Run: python benchmarks/judge_latency.py [--scenes 12] [--repeats 20] [--seed 900]

Submaps of generated tours on their own plans, sixteen placements each. Prints the median and the
95th percentile over all calls, of gathering the evidence and of the network, on one thread.
"""

import argparse
import time

import cv2
import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.graphs import build_region_graph
from fpnet_core.judging import Judge, configured_model, gather_evidence
from fpnet_core.localizer.finder import Finder
from fpnet_core.localizer.scale import tolerant_search
from fpnet_core.localizer.sides import StageTimer, plan_side
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.pose import MapSide, map_evidence
from fpnet_lab.sim.config import SimConfig
from fpnet_lab.sim.pairs import generate_scene


def timed_ms(call, repeats):
    """Durations of ``repeats`` calls [ms], after one that is not counted."""
    call()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append(1e3 * (time.perf_counter() - start))
    return times


def main() -> None:
    """Print one line per part."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--scenes', type=int, default=12)
    parser.add_argument('--repeats', type=int, default=20)
    parser.add_argument('--seed', type=int, default=900)
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    config, sim = FpnetConfig(), SimConfig()
    model = configured_model(config.localizer)
    judge = Judge(model, config.localizer.plan_prior)
    finder = Finder(LearnedMatcher(config.matcher), judge, config)
    search = tolerant_search(config.pose.scale_tolerance, config.pose)
    evidence_ms, network_ms, walls_m, counts = [], [], [], []
    for index in range(arguments.scenes):
        scene = generate_scene(arguments.seed, index * sim.pairs_per_plan, sim)
        plan = plan_side(scene.plan_segmentation)
        graph = build_region_graph(scene.sub_segmentation, 'submap')
        sub = MapSide(scene.sub_segmentation, graph, map_evidence(scene.submap.grid))
        looks = finder.looks(plan, sub, scene.submap.free_area_m2, search, StageTimer())
        *_, found = looks
        placed = found.estimates

        def gather(plan=plan, placed=placed, match=found.match, sub=sub):
            # A tick's submap is new: nothing is derived from it yet.
            fresh = MapSide(sub.segmentation, sub.graph, map_evidence(sub.segmentation.grid))
            start = time.perf_counter()
            gather_evidence(plan, fresh, placed, match, search.log_range)
            return 1e3 * (time.perf_counter() - start)

        gather()
        evidence_ms += [gather() for _ in range(arguments.repeats)]
        evidence = found.verdict.evidence
        network_ms += timed_ms(lambda e=evidence: model.log_probability(e), arguments.repeats)
        walls_m.append(sub.evidence.wall_length_m)
        counts.append(len(placed))
    print(f'{np.mean(counts):.1f} placements, {np.median(walls_m):.0f} m of wall in the median')
    for name, times in (('evidence', evidence_ms), ('network', network_ms)):
        print(f'{name}: median {np.median(times):.1f} ms, p95 {np.percentile(times, 95):.1f} ms')


if __name__ == '__main__':
    main()
