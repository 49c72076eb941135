# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports of benchmarks to the tables and figures that pages show: each says what was measured."""

from benchmark_reports import (
    DRAWINGS,
    MADE,
    SCALES,
    localization,
    peers,
    robot,
    rows,
    site_figures,
)
import pytest

from fpnet_core.errors import ConfigError
from fpnet_lab.evaluation.localization.peers import peer_figures
from fpnet_lab.evaluation.published.makers import published
from fpnet_lab.evaluation.robots.robot_figures import ALL_BANDS


def test_sites_are_told_apart_by_whether_walls_can_tell():
    tables = published('sites', site_figures(), MADE)
    apart, equal = rows(tables['sites'])[2:]
    assert apart[1:4] == ['2', '1', '0']
    assert apart[4:6] == ['12.0 m', '8.0 m']
    assert apart[-1] == '2.5 times'
    assert equal[1:4] == ['1', 'ambiguous 1', '0']
    (found,) = rows(tables['sites.differences'])[2:]
    assert found[:3] == ['90 %', '85 %', '5 %']


def test_figures_of_the_localization_benchmark():
    figures = published('localization', localization(), MADE)
    assert figures['localization.right'] == '2 of 4'
    assert figures['localization.plain_right'] == '2'
    assert figures['localization.first_pose'] == '5.0 m'
    assert figures['localization.false_claims'] == '0'
    lines = {row[0]: row[1:] for row in rows(figures['localization'])}
    assert lines['`exact`'] == ['2', '2', '3.0 m', '0', '0.05 m, 0.4°', '2.8, 93 %', '']
    assert lines['`symmetric`'][2] == '30 m'
    assert lines['`rough`'][:2] == ['1', '0'], 'it counts in no total'
    assert lines['all'][:4] == ['6', '2 of 4', '5.0 m', '3']
    assert lines['on mirrored plans'] == ['1', '', '', '0 claims', '', '', '']


def test_figures_of_peers_are_of_what_all_methods_met():
    [placed] = rows(published('peers', peers(), MADE)['peers.maps'])[2:]
    pairs = 2 * len(ALL_BANDS)
    half = f'{len(ALL_BANDS)} of {pairs}'
    assert placed == ['`fpnet`', half, half, half, f'{pairs} of {2 * pairs}', '0.24 s']
    ours, theirs = rows(published('peers', peers(), MADE)['peers'])[2:]
    assert ours[:4] == ['`fpnet`', '1 of 1', '1 of 1', '0 of 1']
    assert theirs[:4] == ['`monte_carlo`', '1 of 1', '0 of 1', '1 of 1']
    assert (ours[4:6], theirs[5]) == (['2.0 m', '0 of 1'], '1 of 1')
    assert ours[6:] == ['0.05 m', '0.010 s']
    assert peer_figures([]) == {}


def test_figures_of_drawings_and_stated_scales():
    figures = published('drawings', DRAWINGS, MADE)
    assert figures['drawings.right'] == '63 %'
    assert figures['drawings.real_scale_within'] == '93 %'
    assert rows(figures['drawings'])[2] == ['clean', '8', '63 %', '98 %', '', '0 %', '2.4']
    figures = published('stated_scales', SCALES, MADE)
    assert (figures['stated_scales.scatter'], figures['stated_scales.times']) == ('0.010', '280')
    assert rows(figures['stated_scales'])[-1] == ['stated wrong, doubted', '33', '28', '1', '0']


def test_figures_of_robots_maps():
    figures = published('robot', robot(), MADE)
    assert figures['robot.pairs'] == '8'
    assert figures['robot.right_whole'] == '50 %'
    assert figures['robot.undistorted_whole'] == '100 %'
    assert (figures['robot.wrong'], figures['robot.pairs']) == ('4', '8')
    assert (figures['robot.foreign'], figures['robot.foreign_pairs']) == ('8', '16')
    table = rows(figures['robot'])
    assert table[2] == ['all', 'whole', '50 %', '50 %', '1 of 2', '2 of 4']
    assert table[6][:4] == ['without the three distorted drawings', 'whole', '100 %', '100 %']
    assert rows(figures['robot.buildings'])[3] == [
        '`b`',
        '1',
        '0, 0 %',
        '0, 0 %',
        '0, 0 %',
        '4 of 4',
    ]


@pytest.mark.parametrize(('name', 'content'), [('drawings', {'half': 'tune'}), ('nothing', {})])
def test_reports_of_something_else_are_refused(name, content):
    with pytest.raises(ConfigError, match=name):
        published(name, content, MADE)
