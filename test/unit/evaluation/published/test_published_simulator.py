# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How like real storeys generated ones are, how fast, and what a lidar's scan costs."""

from benchmark_reports import MADE, MADE_PER_S, RECORDED, STATISTICS, rows

from fpnet_lab.evaluation.published.makers import joined, published


def test_storeys_stand_beside_real_ones():
    figures = published('statistics', STATISTICS, MADE)
    titles, _, area, cycles = rows(figures['statistics'])
    assert titles == ['200 generated / 10 real storeys', '5 %', '50 %', 'largest error']
    assert area == ['room area [m²]', '5.61 / 4.79', '12 / 14', '17 %']
    assert cycles[-1] == '', 'nothing was fitted to them'
    assert (figures['statistics.auc'], figures['statistics.spread']) == ('0.56', '0.18')


def test_only_pairs_have_an_aim():
    titles, _, pairs, plans, scans = rows(published('simulator', MADE_PER_S, MADE)['simulator'])
    assert titles[0] == '2 workers'
    assert pairs == ['pairs', '8.6 per s', '10.0 per s', 'missed']
    assert plans[2:] == scans[2:] == ['', '']


def test_drift_of_several_kinds_of_clouds_is_one_table():
    both = joined('recordings', [RECORDED, RECORDED | {'clouds': 'instant'}])
    untimed, wheels, instant, _ = rows(published('recordings', both, MADE)['recordings'])[2:]
    assert untimed == [
        *('`beams16`', 'without times', '14400', '21 ms', '30 ms', '1.3', '7.7', '0.19 m')
    ]
    assert wheels[:5] == ['wheels, no lidar', '', '', '', '']
    assert instant[1] == 'of one instant'
