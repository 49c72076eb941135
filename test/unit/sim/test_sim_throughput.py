# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
from itertools import count
from types import SimpleNamespace

from fpnet_lab.sim import throughput
from fpnet_lab.sim.pairs import writing


def test_rates_are_what_was_made_over_the_time_that_it_took(monkeypatch):
    clock = SimpleNamespace(perf_counter=count(step=2.0).__next__)  # two seconds at each look
    monkeypatch.setattr(throughput, 'time', clock)
    for module in (throughput, writing):
        monkeypatch.setattr(module, 'BLOCK_PAIRS', 2)
    monkeypatch.setattr(throughput, 'ROOMS', (8, 14))
    seen = []
    report = throughput.simulator_throughput(
        3, workers=1, blocks=3, plans=5, scans=4, on_pairs=seen.append
    )
    assert seen == [2, 2, 2]
    assert report['pairs'] == 4
    # Two blocks of two pairs after the first one; five plans; four scans.
    assert report['pairs_per_s'] == 4 / 4.0
    assert report['plans_per_s'] == 5 / 2.0
    assert report['scans_per_s'] == 4 / 2.0
    assert report['rooms'] == [8, 14]
