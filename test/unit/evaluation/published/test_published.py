# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports of benchmarks to the tables and figures that pages show: each says what was measured."""

from benchmark_reports import (
    DRAWINGS,
    HOUR,
    MADE,
    NOTHING,
    ON_SHEETS,
    REPORTS,
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


def test_durations_stand_beside_their_aims():
    missed, free = rows(published('speed', REPORTS['speed'](), MADE)['speed'])[2:]
    assert missed == ['match call', '0.0062', '0.0061', '0.005, missed']
    assert free[3] == ''


def test_live_nodes_tell_what_was_lost_and_how_late_they_were():
    told, silent = rows(published('wirings', REPORTS['wirings'](), MADE)['wirings'])[2:]
    assert told[1:] == [
        *('2.3 s', '0.09 m, 0.4 deg', '0.08 m', '0.00 m', '0.14 m/s, 0.08 rad/s', '3 of 449')
    ]
    assert silent[5] == ''
    titles, _, *load = rows(published('node_load', REPORTS['node_load'](), MADE)['node_load'])
    assert titles == ['figure', '25000 points, 10 min']
    assert [cell for _, cell in load] == [
        *('2 of 6000', '18 ms', '8 ms', '37 ms, 128 ms', '0.17 s', '799 MiB', '0.2 %')
    ]


def test_a_library_tells_how_often_the_right_plan_is_proposed():
    tables = published('sites', site_figures(), MADE)
    (drives,) = rows(tables['sites.library'])[2:]
    assert drives == ['drives', '2', '50 %', '50 %', '13 ms']
    assert '1040 plans, 8.1 kB each' in tables['sites.library']
    (grown,) = rows(tables['sites.growth'])[2:]
    assert grown == ['1,000', '8 MB', '20 ms', '98 %']


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


def test_figures_of_the_open_benchmark():
    tables = published('open', REPORTS['open'](), MADE)
    ours, silent = rows(tables['open'])[2:4]
    assert ours[:6] == ['`fpnet`', '2 of 3', '1 of 3', '0 of 3', '4.2 m', '7.5 s']
    assert ours[6:] == ['0.07 m', '0.3 deg', '91', '2 of 3', '0.05', '0.03']
    assert silent[4:] == ['none', 'none', 'none', 'none', '0', '0 of 3', 'none', 'none']
    assert '21 cases: track sheets, seed 1, count 3.' in tables['open']
    titles, _, more, _ = rows(tables['open.more'])
    assert titles[1:3] == ["claimed on other buildings' plans", 'on mirrored plans']
    assert titles[3] == 'finished map', 'the track has no other floors'
    assert more[1:4] == ['0 of 3', '1 of 3', '2 of 3, 0 wrong']


def test_figures_of_drawings_and_stated_scales():
    figures = published('drawings', DRAWINGS, MADE)
    assert figures['drawings.right'] == '63 %'
    assert figures['drawings.real_scale_within'] == '93 %'
    assert rows(figures['drawings'])[2] == ['clean', '8', '63 %', '98 %', '', '0 %', '2.4']
    figures = published('stated_scales', SCALES, MADE)
    assert (figures['stated_scales.scatter'], figures['stated_scales.times']) == ('0.010', '280')
    assert rows(figures['stated_scales'])[-1] == ['stated wrong, doubted', '33', '28', '1', '0']


def test_figures_of_demos_and_logs():
    figures = published('demo', REPORTS['demo'](), MADE)
    assert figures['demo.met'] == '1 of 2'
    assert figures['demo.latest'] == '0.1 m'
    assert rows(figures['demo'])[2] == [
        '0',
        '800',
        '0',
        '1.50',
        '0.15',
        '0.11',
        '0.29',
        '14.90',
        '95.40',
    ]
    without = published(
        'demo', {'seeds': {'0': NOTHING | {'localized': False, 'wrong_poses': 0}}}, MADE
    )
    assert (without['demo.met'], without['demo.latest']) == ('0 of 1', 'never')
    logs = rows(published('real_logs', REPORTS['real_logs'](), MADE)['real_logs'])
    assert logs[2][2:] == ['localized', 'after 2 s, 0 m', '800', '0', '0.11 m, 0.3 deg']
    assert logs[3] == ['intel', 'unknown', 'searching', 'none', '0', '0', '']


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


def test_figures_of_long_drives():
    drift = published('drift', REPORTS['drift'](), MADE)
    assert rows(drift['drift'])[2] == ['open plan, 225 m', '0.30 m', '0.30 m', '0.30 m']
    assert rows(drift['drift.rough'])[2][1:] == ['never claimed', 'never claimed']
    carried = published('carried_off', REPORTS['carried_off'](), MADE)
    assert rows(carried['carried_off'])[2][1:] == ['11', '4', '1.1 s, 3.0 s', '111', '7', '1031']
    _, _, none, gap = rows(published('faults', REPORTS['faults'](), MADE)['faults'])
    assert none[:5] == ['none', '9 of 10', '8', '1.5 s, 4.0 s', '12']
    assert none[5:] == ['0.9 s', '0', '3', '91 %', '2.4 m', '0.07 m']
    assert gap[2:4] == ['0', '']
    walks = published('walks', REPORTS['walks'](), MADE)
    _, _, gyro, _, upstream = rows(walks['walks'])
    assert rows(walks['walks.log'])[2] == ['scans alone', '0.02 m, 0.2°', '1.10', '30 ms']
    assert gyro[:6] == ['with a gyroscope', '20 of 20', '0', '1', '2.0 m', '0.05 m, 0.4°']
    assert upstream[1:4] == ['', '', ''], "upstream's poses are not localised on"


@pytest.mark.parametrize(('name', 'content'), [('drawings', {'half': 'tune'}), ('nothing', {})])
def test_reports_of_something_else_are_refused(name, content):
    with pytest.raises(ConfigError, match=name):
        published(name, content, MADE)


def test_an_hour_is_told_early_and_late():
    figures = published('long_run', HOUR, MADE)
    titles, _, update, *_ = rows(figures['long_run'])
    assert titles == ['figure', 'at 5 minutes, exploring', 'at 60 minutes']
    assert update == ['tick, median', '40 ms', '40 ms']
    assert figures['long_run.explored'] == '937 m²'
    met = {row[0]: row[-1] for row in rows(figures['long_run.aims'])[2:]}
    assert list(met.values()) == ['met', 'met', 'met', 'missed']


def test_sheets_stand_beside_the_clean_floorplan():
    report = {'drives': ON_SHEETS}
    grid, scan = rows(published('sheet_drives', report, MADE)['sheet_drives'])[2:]
    assert grid == [*('clean floorplan, scale stated', '2 of 2', '0', '0', '3.8 m', '', '0.05 m')]
    assert scan == ['scan, picture', '1 of 2', '1', '1', 'none', '2.00', '1.50 m']


def test_clouds_that_arrive_are_told_by_profile():
    report = REPORTS['cloud_transport']()
    titles, _, defaults, shm = rows(published('cloud_transport', report, MADE)['cloud_transport'])
    assert titles == ['of 50 clouds of 300,000 points', 'best effort', 'reliable']
    assert defaults == ['defaults', '21, 151 ms', '21, 151 ms']
    assert shm[0] == '`fastdds_shm.xml`'


def test_an_earlier_program_stands_above_todays():
    figures = published('two_programs', REPORTS['two_programs'](), MADE)
    earlier, today = rows(figures['two_programs'])[2:]
    assert earlier[:3] == ['beams16', 'abc1234', '1.2 m']
    assert [earlier[-1], today[-1]] == ['8.0 s', '6.0 s']
    assert figures['two_programs.times'] == '0.75'
