# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Figures between markers: what pages state, where they disagree, and how they are written."""

from dataclasses import asdict, replace
import json
from pathlib import Path
import subprocess
import sys

import pytest

from fpnet_core.cli import main
from fpnet_core.errors import ConfigError
from fpnet_lab.cli.reports import begin, finish, write_report
from fpnet_lab.evaluation.differences import DifferenceFigures
from fpnet_lab.evaluation.figures import contradictions, pages, stated, write_figures
from fpnet_lab.evaluation.localization.figures import report
from fpnet_lab.evaluation.localization.peers import peer_figures
from fpnet_lab.evaluation.localization.records import Record
from fpnet_lab.evaluation.plan_library import LibraryAnswer, figures_by_group
from fpnet_lab.evaluation.published import MAKERS, published
from fpnet_lab.evaluation.published_rooms import MATCHES
from fpnet_lab.evaluation.robot_figures import ALL_BANDS, Foreign, Outcome, robot_figures
from fpnet_lab.evaluation.site_drives import SiteRun, site_report
from fpnet_lab.provenance import Provenance, machine

ROOT = Path(__file__).resolve().parents[3]
MADE = Provenance('fpnet bench x', 'abc1234', '2026-11-22', '2 cores, AMD EPYC')
SHEETS = {
    'sheets': 8,
    'right': 0.625,
    'wrong_marked': None,
    'good_marked': 0.0,
    'seconds_p50': 2.4,
}
SCALE = {'within_10': 0.925, 'interval_holds': 1.0, 'sure': 0}
VECTORS = {
    'kinds': dict.fromkeys(('clean', 'office', 'brochure'), SHEETS),
    'all': SHEETS,
    'scale': SCALE,
}
DRAWINGS = {'kinds': {'clean': SHEETS}, 'all': SHEETS, 'scale': SCALE, 'bormann': {'scale': SCALE}}
COUNTS = {'cases': 36, 'right': 33, 'claimed right': 28, 'claimed wrong': 1}
SCALES = {
    'scale': {
        'Cauchy': {'width': 0.0101, 'log_likelihood': 10.635},
        'Gaussian': {'width': 0.1, 'log_likelihood': 5.0},
    },
    'x against y': {},
    **{
        f'stated {s}, {way}': COUNTS
        for s in ('right', 'wrong')
        for way in ('trusting', 'doubting')
    },
}


def record(group, is_right=True, path=2.0, poses=10, wrong=0):
    is_open_set = group in ('wrong_building', 'mirrored_plan')
    return Record(
        case=f'{group}-0', group=group, building='suites', sensor='planar', seed=0,
        method='fpnet', plan='own', is_open_set=is_open_set, poses=poses, wrong_poses=wrong,
        is_right=is_right, is_tight=is_right, path_to_first_pose_m=path,
        median_position_error_m=0.051, median_yaw_error_deg=0.44, tick_ms=(10.0,),
        add_scan_ms=1.0, rss_mb=100.0, beliefs=(),
    )  # fmt: skip


def localization():
    honest = replace(record('exact'), nees_mean=2.8, inside_95=0.93)
    records = [honest, record('exact', path=4.0), record('sketch', False, 6.0, wrong=3)]
    records.append(record('rough', False))
    nothing = [
        record('wrong_building', path=None, poses=0),
        record('mirrored_plan', path=None, poses=0),
    ]
    return report([*records, record('symmetric', False, 30.0), *nothing])


RUN = {
    'localized': True,
    'poses': 800,
    'wrong_poses': 0,
    'time_to_first_pose_s': 1.5,
    'path_to_first_pose_m': 0.15,
    'median_position_error_m': 0.11,
    'median_yaw_error_deg': 0.29,
    'tick_ms_p50': 14.9,
    'tick_ms_p95': 95.4,
    'status_over_time': ['searching', 'localized'],
}
NOTHING = dict.fromkeys(RUN) | {'poses': 0, 'status_over_time': ['searching']}
OFF = {'p50_m': 0.1, 'p95_m': 0.2, 'max_m': 0.3, 'max_deg': 1.0}
DRIVE = {
    'family': 'open_plan',
    'path_m': 225.4,
    'exact': {'odometry': OFF, 'whole_submap': OFF, 'published': OFF},
    'rough': {'claimed_ticks': 0},
}
CARRIED = {
    'localized': 11,
    'withheld': 4,
    'withheld_s_median': 1.1,
    'withheld_s_max': 3.0,
    'wrong_poses': 111,
    'found_again': 7,
    'right_poses': 1031,
}
WIRED = {
    'robot': '3D lidar alone',
    'sweeps': 449,
    'first_pose_s': 2.31,
    'error_m': 0.094,
    'error_deg': 0.41,
    'offline_error_m': 0.08,
    'lost': {'localizer missed': 1.0, 'odometry lost': 2.0},
    'tf_error_m': 0.001,
    'twist_error': [0.141, 0.08],
}
TIMED = {'seconds': 0.00618, 'cpu_s': 0.0061, 'aim_s': 0.005, 'of': 5}
LOAD = {
    'scans_sent': 6000,
    'scans_lost': 2.0,
    'tf_jitter_max': 17.9,
    'call_p99': 8.03,
    'tick_p50': 36.6,
    'tick_p99': 128.2,
    'pose_behind_max_s': 0.165,
    'memory_mib': 799.1,
    'memory_growth_second_half_percent': 0.22,
}


def robot():
    foreign = (Foreign(is_same_architect=True, is_claimed=True), Foreign(False, False))
    outcomes = [
        Outcome(band, building, building == 'b', is_right, is_claimed, foreign)
        for band in ALL_BANDS
        for building, is_right, is_claimed in (('a', True, True), ('b', False, True))
    ]
    return {'methods': {'fpnet': robot_figures(outcomes)}}


def peers():
    own, rival = record('exact'), replace(record('exact', wrong=2), method='monte_carlo')
    other = replace(record('wrong_building', path=None, poses=0), plan='other')
    fooled = replace(other, method='monte_carlo', poses=5)
    unmet = replace(other, plan='met by the localizer only', poses=3)
    maps = {
        name: {**figures, 'ms_per_pair': 240.0} for name, figures in robot()['methods'].items()
    }
    return {'methods': peer_figures([own, other, unmet, rival, fooled]), 'maps': maps}


SITE_RUN = SiteRun(
    'bays_3', 3, 2, 0.12, True, 0, 0, 'localized', 12.0, 8.0, 150.0, 60.0
)  # fmt: skip
SITE_RUNS = [
    SITE_RUN,
    replace(SITE_RUN, storeys=12, is_right=False, path_m=None),
    replace(SITE_RUN, least_different=0.0, path_m=None, status='ambiguous'),
]


def site_figures():
    found = DifferenceFigures(0.9, 0.85, 0.05, 0.5, 40, 36)
    asked = [LibraryAnswer('drives', 1, 12.0), LibraryAnswer('drives', None, 14.0)]
    library = {
        'plans': 1040,
        'kilobytes_a_plan': 8.05,
        'groups': figures_by_group(asked),
        'claims': {'right': 0.9, 'wrong': 0.0},
        'growth': [
            {'plans': 1000, 'megabytes': 8.1, 'query_ms_median': 20.0, 'in_first_10': 0.975}
        ],
    }
    differences = asdict(found)
    one = {'drives': 2, 'same': 2}
    for name in ('tick_ms', 'scan_ms'):
        one |= {name: 9.0, f'{name}_site': 9.1, f'{name}_ratio': 1.01, f'{name}_ratio_spread': 0.1}
    sites = site_report(SITE_RUNS)
    return {'sites': sites, 'one': one, 'differences': differences, 'library': library}


FOUND = {
    'precision': 0.985,
    'recall': 0.97,
    'f1': 0.958,
    'doors_precision': 0.9594,
    'doors_recall': 0.92,
    'seconds_per_map_median': 0.051,
}
PLANS = {'clean': FOUND, 'furnished': FOUND}
MAPS = {'default': FOUND, 'morphological': FOUND, 'distance': FOUND, 'tune': FOUND}
DRIVES = {
    'room_iou_mean': 0.921,
    'rooms_over_iou50': 0.975,
    'doors_precision': 0.915,
    'doors_recall': 0.94,
    'rooms': 80,
    'recordings': 15,
}
SEGMENTATION = {
    **PLANS,
    'baselines': {'morphological': PLANS, 'distance': PLANS},
    'plans': 10,
    'robot_maps': {**MAPS, 'report': FOUND | {'f1': 0.699}, 'maps': 15, 'left_out': ['lab_x']},
    'submap': DRIVES
    | {'by_sensor': {'beams16': DRIVES, 'planar': DRIVES | {'room_iou_mean': 0.86}}},
}
TOLD = {
    'estimates': 10,
    'within_10': 0.4,
    'held': 0.7,
    'spread': 1.636,
    'sure': 0.0,
    'sure_wrong': 0.0,
    'ms_per_drawing': 90.0,
}
FACTORS = [{'group': 'homes', 'factor': factor} for factor in (1.2, 1.42, 1.5)]
SCALES_TOLD = {
    'groups': {'report bare': TOLD, 'homes': TOLD | {'held': 0.27}, 'generated': TOLD},
    'drawings': [*FACTORS, {'group': 'report bare', 'factor': 0.9}],
}
MATCHED = {'ts': 0.918, 'ms': 0.9, 'auc10': 0.877, 'recall_1m_10deg': 0.92}

REPORTS = {
    **dict.fromkeys(('segmentation', 'submaps', 'submaps_3000'), lambda: SEGMENTATION),
    'scale': lambda: SCALES_TOLD,
    **dict.fromkeys(MATCHES, lambda: {'methods': {'fpnet': MATCHED}, 'pairs': 500}),
    'sites': site_figures,
    'localization': localization,
    'peers': peers,
    'drawings': lambda: DRAWINGS,
    **dict.fromkeys(('drawings_pdf', 'drawings_svg', 'drawings_dxf'), lambda: VECTORS),
    'stated_scales': lambda: SCALES,
    'demo': lambda: {'seeds': {'0': RUN, '1': RUN | {'wrong_poses': 2}}},
    'real_logs': lambda: {'logs': {'intel': {'nothing': RUN, 'unknown': NOTHING}}},
    'robot': robot,
    'drift': lambda: {'drives': [DRIVE]},
    'carried_off': lambda: {'drives': [{}], 'ways': {'asked': CARRIED, 'not_asked': CARRIED}},
    'speed': lambda: {'figures': {'match call': TIMED, 'a start': TIMED | {'aim_s': None}}},
    'wirings': lambda: {'robots': [WIRED, WIRED | {'twist_error': None}]},
    **dict.fromkeys(('node_load', 'node_load_kiss'), lambda: {'phases': {'25000 points': LOAD}}),
}


def rows(table):
    lines = [line for line in table.splitlines() if line.startswith('|')]
    return [[cell.strip() for cell in line.strip('|').split('|')] for line in lines]


def test_pages_agree_on_every_figure():
    on_pages = [each for page in pages(ROOT) for each in stated(page)]
    assert contradictions(on_pages) == []
    assert len({each.page for each in on_pages}) >= 3


def test_every_figure_on_a_page_is_one_that_a_benchmark_gives():
    known = {'constants'}
    for name in MAKERS:
        known |= set(published(name, REPORTS[name](), MADE))
    named = {each.name for page in pages(ROOT) for each in stated(page)}
    assert named <= known


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


def test_every_table_on_a_page_says_what_made_it():
    tables = [each for page in pages(ROOT) for each in stated(page) if '\n' in each.text]
    for each in tables:
        assert each.text.startswith('`'), f'{each.page.name}: {each.name}'
        assert 'commit ' in each.text.partition('\n')[0], f'{each.page.name}: {each.name}'
    assert len(tables) >= 4


def on_pages():
    """What all pages state, by name; they agree, as another test has it."""
    return {each.name: each.text for page in pages(ROOT) for each in stated(page)}


MEASURED_APART = {
    'sites.differences': 'sites.differences',
    'sites.one': 'sites.one',
    'sites.library': 'sites.library',
    'sites.growth': 'sites.library',
}
"""Parts of a benchmark that have nothing in common but its name."""


def test_tables_of_one_benchmark_are_of_one_run():
    """Their first lines have the command, the day and the commit."""
    made = {}
    for name, text in on_pages().items():
        if '\n' in text:
            run = MEASURED_APART.get(name, name.partition('.')[0])
            made.setdefault(run, set()).add(text.partition('\n')[0])
    assert {name: lines for name, lines in made.items() if len(lines) > 1} == {}


def test_every_figure_in_a_sentence_has_its_table_on_a_page():
    """The table says where the figure is from; scales of vector drawings are one row each."""
    names = on_pages()
    tables = {name.partition('.')[0] for name, text in names.items() if '\n' in text}
    sentences = {name.partition('.')[0] for name, text in names.items() if '\n' not in text}
    assert sentences - tables <= {'drawings_pdf', 'drawings_svg', 'drawings_dxf'}


def test_figures_in_sentences_are_those_of_the_tables():
    figures = on_pages()
    table = {row[0]: row for row in rows(figures['localization'])}
    assert figures['localization.right'] == table['all'][2]
    assert figures['localization.first_pose'] == table['all'][3]
    claims = [row for name, row in table.items() if name.startswith('on ')]
    assert len(claims) == 2
    false = sum(int(row[4].split()[0]) for row in claims)
    assert figures['localization.false_claims'] == str(false)
    undistorted = [row[2] for row in rows(figures['robot'])[-4:]]
    names = ('whole', 'half', 'third', 'tenth')
    assert [figures[f'robot.right_{name}'] for name in names] == undistorted
    seeds = rows(figures['demo'])[2:]
    assert figures['demo.met'].endswith(f'of {len(seeds)}')
    assert figures['demo.wrong'] == str(sum(int(row[2]) for row in seeds))
    assert figures['demo.latest'] == f'{max(float(row[4]) for row in seeds):.1f} m'


def test_the_readme_says_on_how_many_foreign_plans_it_was_tried():
    table = {row[0]: row for row in rows(on_pages()['localization'])}
    foreign = sum(int(row[1]) for name, row in table.items() if name.startswith('on '))
    assert f' of {foreign} drives' in (ROOT / 'README.md').read_text(encoding='utf-8')


def test_pages_that_disagree_are_named(tmp_path):
    for name, text in {'README.md': '60 of 66', 'docs/a.md': '61 of 66'}.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f'Right: <!-- f:suite.right -->{text}<!-- / -->.\n')
    on_pages = [each for page in pages(tmp_path) for each in stated(page)]
    (line,) = contradictions(on_pages)
    assert 'suite.right' in line
    assert '61 of 66' in line
    changed = write_figures(pages(tmp_path), {'suite.right': '62 of 66', 'other': '1'})
    assert [page.name for page in changed] == ['README.md', 'a.md']
    assert (tmp_path / 'README.md').read_text() == (
        'Right: <!-- f:suite.right -->62 of 66<!-- / -->.\n'
    )
    assert write_figures(pages(tmp_path), {'suite.right': '62 of 66'}) == []


@pytest.mark.parametrize(
    'text',
    [
        '<!-- figures: a -->\n| 1 |\n',
        'x <!-- f:a -->1\n<!-- / -->',
        'x\n<!-- f:a -->1<!-- / -->',
        '<!--f:a-->1<!-- / -->',
    ],
)
def test_a_marker_that_is_not_closed_is_refused_and_nothing_is_written(tmp_path, text):
    good, bad = tmp_path / 'good.md', tmp_path / 'bad.md'
    good.write_text('Is <!-- f:a -->1<!-- / -->')
    bad.write_text(text)
    with pytest.raises(ConfigError, match=r'bad\.md'):
        write_figures([good, bad], {'a': '2'})
    assert '1' in good.read_text()


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


def test_figures_of_robots_maps():
    figures = published('robot', robot(), MADE)
    assert figures['robot.pairs'] == '8'
    assert figures['robot.right_whole'] == '100 %'
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


@pytest.mark.parametrize('name', REPORTS)
def test_a_benchmark_ends_with_the_tables_that_pages_have(name, tmp_path, capsys):
    report = json.loads(json.dumps(REPORTS[name]()))
    finish(name, tmp_path / 'report.json', report)
    shown = capsys.readouterr().out
    tables = [text for text in published(name, report, MADE).values() if '\n' in text]
    assert tables
    for text in tables:
        assert text.partition('\n\n')[2].strip() in shown
    written = json.loads((tmp_path / 'report.json').read_text())
    assert written.pop('made')['commit'] is not None
    assert written == report


def test_a_table_in_a_page_stays_one_after_writing(tmp_path):
    page = tmp_path / 'README.md'
    page.write_text('Above.\n\n<!-- figures: drawings -->\n<!-- end -->\n\nBelow.\n')
    write_figures([page], published('drawings', DRAWINGS, MADE))
    lines = page.read_text().splitlines()
    assert lines[3].startswith('`fpnet bench x` (2026-11-22, commit abc1234')
    assert lines[lines.index('<!-- end -->') - 1] == ''
    assert lines[-1] == 'Below.'


@pytest.mark.parametrize(('name', 'content'), [('drawings', {'half': 'tune'}), ('nothing', {})])
def test_reports_of_something_else_are_refused(name, content):
    with pytest.raises(ConfigError, match=name):
        published(name, content, MADE)


def test_the_command_writes_pages_and_asks_how_a_report_was_made(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'docs').mkdir()
    page, file = tmp_path / 'README.md', tmp_path / 'drawings.json'
    page.write_text('Read right: <!-- f:drawings.right -->?<!-- / -->\n')
    file.write_text(json.dumps(DRAWINGS))
    with pytest.raises(SystemExit, match='1'):
        main(['bench', 'figures', f'drawings={file}'])
    assert 'does not say how it was made' in capsys.readouterr().err
    file.write_text(json.dumps(MADE.in_report(DRAWINGS)))
    with pytest.raises(SystemExit, match='0'):
        main(['bench', 'figures', f'drawings={file}'])
    assert '-->63 %<!--' in page.read_text()


def test_provenance_is_of_this_checkout():
    made = Provenance.now()
    git = subprocess.run(
        ['git', '-C', ROOT, 'rev-parse', 'HEAD'], capture_output=True, text=True, check=False
    )
    if git.returncode == 0:
        assert git.stdout.startswith(made.commit.removesuffix('+'))
    assert made.machine == machine()
    assert Provenance.of(made.in_report({'a': 1})) == made
    assert Provenance.of({}) is None
    with pytest.raises(ConfigError, match='run the benchmark again'):
        Provenance.of({'made': {'by': 'hand'}})


def test_a_report_is_of_what_began_it(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, 'argv', ['fpnet', 'bench', 'scale', '--json', 'a', '--plot=b', '-x'])
    begin()
    monkeypatch.setattr(sys, 'argv', ['fpnet', 'something', 'else'])
    write_report(tmp_path / 'report.json', {})
    made = json.loads((tmp_path / 'report.json').read_text())['made']
    assert made['command'] == 'fpnet bench scale -x'
