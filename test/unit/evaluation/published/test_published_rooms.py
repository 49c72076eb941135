# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rooms, doors, scales and matches, as pages show them."""

from benchmark_reports import CLOUDS, LOST, MADE, MAPS, MATCHED, SCALES_TOLD, SEGMENTATION, rows
import pytest

from fpnet_core.errors import ConfigError
from fpnet_lab.evaluation.published.makers import joined, published


def test_rooms_and_doors_say_themselves_which_aims_they_miss():
    figures = published('segmentation', SEGMENTATION, MADE)
    plans = rows(figures['segmentation'])[2:]
    assert plans[0] == [
        *('default', 'clean', '98.5 %', '97.0 %', '95.8 %', '95.9 %', '92.0 %', '0.05 s')
    ]
    assert [row[:2] for row in plans[2:4]] == [
        ['morphological', 'clean'],
        ['morphological', 'furnished'],
    ]
    maps = rows(figures['segmentation.maps'])[2:]
    assert [row[:2] for row in maps[:3]] == [
        ['default', 'tune half'],
        ['default', 'report half'],
        ['default', 'all 15'],
    ]
    assert 'Left out: lab_x.' in figures['segmentation.maps']
    aims = {row[0]: row[1:] for row in rows(figures['segmentation.aims'])[2:]}
    assert aims['clean, door P'] == ['95.9 %', '96.0 %', 'missed']
    assert aims['clean, door R'] == ['92.0 %', '92.0 %', 'met']
    assert aims["robots' maps of the report half, F1"] == ['69.9 %', '70.0 %', 'missed']
    assert len(aims) == 7
    alone = {**SEGMENTATION, 'robot_maps': {**MAPS, 'maps': 1, 'left_out': []}}
    unknown = rows(published('segmentation', alone, MADE)['segmentation.aims'])[-1]
    assert unknown[1:] == ['', '70.0 %', 'missed'], 'what was not measured is not met'


def test_submaps_have_an_aim_for_each_sensor():
    figures = published('submaps', SEGMENTATION, MADE)
    sensor, planar, everything = rows(figures['submaps'])[2:]
    assert sensor == ['16 beams, ±15°', '15', '80', '0.92', '0.97', '0.92', '0.94']
    assert (planar[0], planar[3], everything[0]) == ('planar', '0.86', 'all')
    aims = {row[0]: row[1:] for row in rows(figures['submaps.aims'])[2:]}
    assert aims == {
        'room IoU, mean': ['0.921', '0.920', 'met'],
        'doors P': ['0.915', '0.940', 'missed'],
        'doors R': ['0.940', '0.940', 'met'],
        'rooms found': ['97.5 %', '97.0 %', 'met'],
        'room IoU, 16 beams': ['0.921', '0.880', 'met'],
        'room IoU, planar': ['0.860', '0.860', 'met'],
    }
    without = {key: value for key, value in SEGMENTATION.items() if key != 'submap'}
    with pytest.raises(ConfigError, match='submap'):
        published('submaps', without, MADE)


def test_scales_of_homes_are_named():
    figures = published('scale', SCALES_TOLD, MADE)
    assert figures['scale.homes_times'] == '1.4'
    assert (figures['scale.homes_held'], figures['scale.report_held']) == ('27 %', '70 %')
    bare = rows(figures['scale'])[2]
    assert bare == ['report half', '10', '40 %', '70 %', '1.64', '0 %', '0 %', '90 ms']


def test_matches_of_each_set_have_their_own_aims():
    report = {'methods': {'fpnet': MATCHED}, 'pairs': 500}
    real = rows(published('matching_real', report, MADE)['matching_real'])
    assert real[0][0] == '`real`, 500 pairs'
    assert real[2:] == [
        ['TS', '91.8 %', '97.0 %', 'missed'],
        ['MS', '90.0 %', '82.0 %', 'met'],
        ['AUC@10', '87.7 %', '86.0 %', 'met'],
        ['1 m, 10°', '92.0 %', '', ''],
    ]
    tours = rows(published('matching_tours', report, MADE)['matching_tours'])[2:]
    assert all(row[2:] == ['', ''] for row in tours)


def test_finished_clouds_are_told_by_survey_and_run():
    other = CLOUDS | {'seed': 50, 'clouds': [CLOUDS['clouds'][0]]}
    both = joined('finished_clouds', [CLOUDS, other])
    first, second = rows(published('finished_clouds', both, MADE, MADE)['finished_clouds'])[2:]
    assert first == ['SLAM map, seed 1000', '2', '40', '0.87', '100 %', '1 of 2', '0.80']
    assert second == ['SLAM map, seed 50', '1', '10', '0.90', '100 %', '1 of 1', '']


def test_what_rooms_of_submaps_lose_is_told_by_sensor():
    report = {'sensors': {'beams16': LOST, 'all': LOST}}
    sensor, everything = rows(published('submap_losses', report, MADE)['submap_losses'])[2:]
    assert sensor[:3] == ['16 beams', '54', '0.951']
    assert everything == ['all', *sensor[1:]]
