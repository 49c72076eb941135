# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
from fpnet_lab.sim import throughput, writing


def test_every_rate_is_counted(monkeypatch):
    for module in (throughput, writing):
        monkeypatch.setattr(module, 'BLOCK_PAIRS', 2)
    monkeypatch.setattr(throughput, 'ROOMS', (8, 14))
    seen = []
    report = throughput.simulator_throughput(
        3, workers=1, blocks=3, plans=5, scans=4, on_pairs=seen.append
    )
    assert seen == [2, 2, 2]
    assert report['pairs'] == 4
    assert all(report[f'{name}_per_s'] > 0.0 for name in ('pairs', 'plans', 'scans'))
    assert report['rooms'] == [8, 14]
