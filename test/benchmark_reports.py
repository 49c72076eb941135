# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Small reports of every benchmark whose tables pages show, as ``--json`` has them."""

from dataclasses import asdict, replace
from functools import partial
import json
from pathlib import Path

import fpnet_core
from fpnet_lab.evaluation.localization.figures import report
from fpnet_lab.evaluation.localization.peers import peer_figures
from fpnet_lab.evaluation.localization.records import Record
from fpnet_lab.evaluation.published.rooms import MATCHES
from fpnet_lab.evaluation.published.weights import WEIGHTS
from fpnet_lab.evaluation.robots.robot_figures import ALL_BANDS, Foreign, Outcome, robot_figures
from fpnet_lab.evaluation.sites.differences import DifferenceFigures
from fpnet_lab.evaluation.sites.plan_library import LibraryAnswer, figures_by_group
from fpnet_lab.evaluation.sites.site_drives import SiteRun, site_report
from fpnet_lab.provenance import Provenance

MADE = Provenance('fpnet bench x', 'abc1234', '2026-11-22', '2 cores, AMD EPYC')
SHEETS = {
    'sheets': 8, 'right': 0.625, 'wrong_marked': None, 'good_marked': 0.0, 'seconds_p50': 2.4,
}  # fmt: skip
SCALE = {'within_10': 0.925, 'interval_holds': 1.0, 'sure': 0}
ALIGNED = {
    'status': 'aligned',
    **dict.fromkeys(('walls_m', 'median_m', 'p90_m', 'explained', 'error_m', 'worst_m'), 0.25),
    **dict.fromkeys(('sigma_m', 'rmf_m'), 0.1),
    'back_m': None,
}
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
    'localized': True, 'poses': 800, 'wrong_poses': 0, 'time_to_first_pose_s': 1.5,
    'path_to_first_pose_m': 0.15, 'median_position_error_m': 0.11, 'median_yaw_error_deg': 0.29,
    'tick_ms_p50': 14.9, 'tick_ms_p95': 95.4, 'status_over_time': ['searching', 'localized'],
}  # fmt: skip
NOTHING = dict.fromkeys(RUN) | {'poses': 0, 'status_over_time': ['searching']}
OFF = {'p50_m': 0.1, 'p95_m': 0.2, 'p95_deg': 0.8, 'max_m': 0.3, 'max_deg': 1.0}
DRIVE = {
    'family': 'open_plan',
    'path_m': 225.4,
    'exact': {'odometry': OFF, 'whole_submap': OFF, 'published': OFF},
    'rough': {'claimed_ticks': 0},
    'wheels': {'whole_submap': OFF, 'published': OFF},
}
CARRIED = {
    'localized': 11, 'withheld': 4, 'withheld_s_median': 1.1, 'withheld_s_max': 3.0,
    'wrong_poses': 111, 'found_again': 7, 'right_poses': 1031,
}  # fmt: skip
SEEDED = {
    'kidnaps': 10,
    'reseeded': 9,
    'reseeded_s_median': 11.2,
    'reseeded_s_max': None,
    'right_at_the_end': 8,
    'seeds': 19,
    'wrong_seeds': 0,
    'wrong_first_poses': 1,
    'exact': {'first_poses': 150, 'nees_mean': 2.74, 'inside_95': 0.953},
    'sketch': {'first_poses': 0, 'nees_mean': None, 'inside_95': None},
}
FAULTY = {'is': 'loop', 'drives': 4, 'first': 3, 'alone': 3, 'else': 'nothing (1)'}
SHORT = {
    'pieces': 84, 'seen_m2': 40.0, 'right': 0.5, 'claimed_right': 0.4, 'wrong': 1, 'foreign': 2,
    'seconds': 0.15,
}  # fmt: skip
EXPLORED = {'buildings': 20, 'localised': 0.75, 'mean_m': 9.5, 'median_m': 6.0, 'wrong': 0}
WALK = {
    'walks': 20, 'first_m': 2.0, 'median_deg': 0.4, 'second_m': 0.02, 'second_deg': 0.2,
    'second_m_max': 0.05, 'path_max': 1.04, 'register_ms': 30.0,
}  # fmt: skip

ENDED = {'launches': 25, 'clean': 25, 'took_s_median': 0.9, 'took_s_max': 1.4, 'faults': []}

FAULT = {
    'drives': 10, 'before': 9, 'recovered': 8, 'recovery_s_median': 1.5, 'recovery_s_max': 4.0,
    'off': 12, 'longest_s': 0.9, 'long_off': 0, 'wrong': 3, 'localized': 0.91, 'first_m': 2.4,
    'median_m': 0.07,
}  # fmt: skip
NO_RECOVERY = {'recovered': 0, 'recovery_s_median': None, 'recovery_s_max': None}
WIRED = {
    'robot': '3D lidar alone', 'sweeps': 449, 'first_pose_s': 2.31, 'error_m': 0.094,
    'error_deg': 0.41, 'offline_error_m': 0.08,
    'lost': {'localizer missed': 1.0, 'odometry lost': 2.0}, 'tf_error_m': 0.001,
    'twist_error': [0.141, 0.08],
}  # fmt: skip
TIMED = {'seconds': 0.00618, 'cpu_s': 0.0061, 'aim_s': 0.005, 'of': 5}
LOAD = {
    'scans_sent': 6000, 'scans_lost': 2.0, 'tf_jitter_max': 17.9, 'call_p99': 8.03,
    'tick_p50': 36.6, 'tick_p99': 128.2, 'pose_behind_max_s': 0.165, 'memory_mib': 799.1,
    'memory_growth_second_half_percent': 0.22,
}  # fmt: skip


def robot():
    foreign = (Foreign(is_same_architect=True, is_accepted=True), Foreign(False, False))
    outcomes = [
        Outcome(band, building, building == 'b', is_right, is_accepted, foreign)
        for band in ALL_BANDS
        for building, is_right, is_accepted in (('a', True, True), ('b', False, True))
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
    'precision': 0.985, 'recall': 0.97, 'f1': 0.958, 'doors_precision': 0.9594,
    'doors_recall': 0.92, 'seconds_per_map_median': 0.051,
}  # fmt: skip
PLANS = {'clean': FOUND, 'furnished': FOUND}
MAPS = {'default': FOUND, 'morphological': FOUND, 'distance': FOUND, 'tune': FOUND}
DRIVES = {
    'room_iou_mean': 0.921, 'rooms_over_iou50': 0.975, 'doors_precision': 0.915,
    'doors_recall': 0.94, 'rooms': 80, 'recordings': 15,
}  # fmt: skip
SEGMENTATION = {
    **PLANS,
    'baselines': {'morphological': PLANS, 'distance': PLANS},
    'plans': 10,
    'robot_maps': {**MAPS, 'report': FOUND | {'f1': 0.699}, 'maps': 15, 'left_out': ['lab_x']},
    'submap': DRIVES
    | {'by_sensor': {'beams16': DRIVES, 'planar': DRIVES | {'room_iou_mean': 0.86}}},
}
TOLD = {
    'estimates': 10, 'within_10': 0.4, 'held': 0.7, 'spread': 1.636, 'sure': 0.0,
    'sure_wrong': 0.0, 'ms_per_drawing': 90.0,
}  # fmt: skip
FACTORS = [{'group': 'homes', 'factor': factor} for factor in (1.2, 1.42, 1.5)]
SCALES_TOLD = {
    'groups': {'report bare': TOLD, 'homes': TOLD | {'held': 0.27}, 'generated': TOLD},
    'drawings': [*FACTORS, {'group': 'report bare', 'factor': 0.9}],
}
MATCHED = {'ts': 0.918, 'ms': 0.9, 'auc10': 0.877, 'recall_1m_10deg': 0.92}


def varied(factor, **answers):
    """A report of constants of one package that were varied: by name, what they did."""
    rows = [
        {'module': 'fpnet_core.pose.verify', 'name': name, 'answer': answer, 'first': first}
        for name, (answer, first) in answers.items()
    ]
    return {'factor': factor, 'cases': 3, 'rows': rows}


VARIED = varied(
    1.2,
    A=('changed', 'x 1.20: drive-1: other status'),
    B=('changed', 'only together: pair-3: other place'),
    C=('changed', 'x 0.83: pair-3: takes far longer'),
    D=('nothing', ''),
    E=('not run', ''),
)
STOREY = {
    'area_m2': 20_000.0, 'rooms': 426, 'explored_m2': 3173.0, 'plan': [1.6, 1.48],
    'update': [1.15, 1.05], 'stages_s': {'match': 0.09, 'segment': 0.43},
    'peak_bytes': 980_000_000, 'status': 'waiting',
}  # fmt: skip
GROWTH = {'growth': [STOREY | {'area_m2': 300.0, 'rooms': 11}, STOREY]}
READ = {
    'reader': 'images',
    'inputs': 1626,
    **{'accepted': 407, 'refused': 1218, 'unclear': 1, 'exception': 0, 'memory': 0},
    **{'executed': 0, 'timeout': 0, 'crash': 0, 'slowest_cpu_s': 0.04, 'most_memory_mib': 1},
}
WHEELS = {
    'environments': [
        {'python': '3.11', 'extra': 'none', 'megabytes': 1610, 'seconds': 94.2},
        {'python': '3.11', 'extra': 'ros', 'megabytes': 1780, 'seconds': 31.0},
    ]
}
ARRIVED = [
    {'profile': profile, 'subscription': each, 'arrived': arrived, 'latency_ms': 151.2}
    for profile, arrived in (('defaults', 21), ('fastdds_shm.xml', 50))
    for each in ('best effort', 'reliable')
]
RELIABLE = {
    'ece': 0.009, 'right_best': 0.94, 'own_trials': 200, 'claims': 180, 'wrong_claims': 1,
    'foreign_claims': 2, 'foreign_trials': 364,
}  # fmt: skip
CUTS = RELIABLE | {'maps': 100}
RULE = {
    'looks': 2,
    'probability': 0.99,
    'news_m2': 5.0,
    'first_m': 2.5,
    **{'own': 42, 'never': 2, 'wrong': 0, 'foreign': 126, 'foreign_claims': 1},
}
JUDGED = {'right': 0.78, 'claimed_right': 0.4, 'claimed_wrong': 0.009, 'trials': 90}
EARLY = {
    'minute': 5.0, 'tick_ms_p50': 40.0, 'tick_ms_p95': 351.0, 'add_scan_ms_p50': 8.6,
    'rss_mb_max': 700.0,
}  # fmt: skip
HOUR = {
    'early': EARLY,
    'late': EARLY | {'minute': 60.0, 'tick_ms_p95': 52.0, 'rss_mb_max': 1207.0},
    'late_over_early_tick_cpu_p50': 1.13,
    'explored_m2': 937.2,
}
ON_GRID = {'seed': 1, 'sheet': 'grid', 'found_after_m': 3.6, 'error_m': 0.05, 'doubts': []}
ON_SHEETS = [
    ON_GRID,
    ON_GRID | {'seed': 2, 'found_after_m': 4.0},
    ON_GRID | {'sheet': 'scan picture', 'found_after_m': 7.2, 'error_m': 1.5, 'doubts': ['faint']},
    ON_GRID | {'sheet': 'scan picture', 'seed': 2, 'found_after_m': None, 'error_m': None},
]
CLOUD = {
    'how': 'slam', 'seed': 1000, 'rooms': 10, 'found': 1.0, 'iou': 0.9, 'status': 'matched',
    'of_two': [],
}  # fmt: skip
CLOUDS = {
    'seed': 1000,
    'clouds': [
        CLOUD,
        CLOUD | {'rooms': 30, 'iou': 0.86, 'status': 'ambiguous', 'of_two': [0.7, 0.9]},
    ],
}
LOST = {'rooms': 54, 'shipped': 0.951, 'decided': 0.959, 'cut': 0.964, 'returns': 0.013}
LOST |= {'unseen': 0.005, 'free': 0.005, 'beyond': 0.014}
SCANNED = {'rays': 14_400, 'scan_ms': 21.4, 'odometry_ms': 30.0}
SCANNED |= {'metres': 1.31, 'degrees': 7.7, 'end_m': 0.19}
RECORDED = {
    'clouds': 'untimed',
    'sensors': {
        'beams16': SCANNED,
        'wheels, no lidar': SCANNED | dict.fromkeys(('rays', 'scan_ms', 'odometry_ms')),
    },
}
STATISTICS = {
    'generated': 200,
    'real': 10,
    'at': [5, 50],
    'percentiles': {
        'room_area_m2': {'generated': [5.61, 12.4], 'real': [4.79, 14.0]},
        'cycles_per_plan': {'generated': [0.0, 3.0], 'real': [0.0, 4.5]},
    },
    'percentile_error': {'room_area_m2_p5': 0.171, 'room_area_m2_p50': -0.12},
    'regions_auc': 0.561,
    'regions_auc_spread': 0.18,
}
MADE_PER_S = {'pairs_per_s': 8.6, 'plans_per_s': 11.44, 'scans_per_s': 192.0, 'workers': 2}


def manifest(name):
    """What is beside the weights that ship."""
    path = Path(fpnet_core.__path__[0]) / 'weights' / f'{name.removeprefix("weights_")}.json'
    return json.loads(path.read_text(encoding='utf-8'))


def _two_programs():
    run = {'path_to_first_pose_m': 1.25, 'poses': 9, 'wrong_poses': 0, 'poses_on_others': 0}
    run |= {'median_position_error_m': 0.03, 'median_yaw_error_deg': 0.2, 'processor_s': 8.0}
    return {'sensor': 'beams16', 'earlier': run, 'today': {**run, 'processor_s': 6.0}}


def open_report():
    nothing = dict.fromkeys(('foreign', 'mirrored', 'other_floor'), 0)
    counts = {
        f'{name}{key}': value
        for name in ('drive', 'map', 'path_30_m', 'path_15_m', 'one_scan')
        for key, value in {'': 3, '_right': 2, '_claimed_right': 1, '_claimed_wrong': 0}.items()
    }
    claimed = {'foreign_claimed': 0, 'mirrored_claimed': 1, 'other_floor_claimed': 0}
    ours = nothing | counts | claimed | {'foreign': 3, 'mirrored': 3, 'failed': 0}
    ours |= {'first_pose_m': 4.25, 'first_pose_s': 7.5, 'position_m': 0.071, 'yaw_deg': 0.3}
    ours |= {'challenge': 91.4, 'sequences': 3, 'successes': 2, 'ece': 0.052, 'brier': 0.03}
    silent = dict.fromkeys(
        ('first_pose_m', 'first_pose_s', 'position_m', 'yaw_deg', 'ece', 'brier')
    )
    programs = {'fpnet': ours, 'silent': ours | silent | {'challenge': 0.0, 'successes': 0}}
    return {'track': 'sheets', 'seed': 1, 'count': 3, 'cases': 21, 'programs': programs}


REPORTS = {
    **dict.fromkeys(('segmentation', 'submaps', 'submaps_3000'), lambda: SEGMENTATION),
    'scale': lambda: SCALES_TOLD,
    **dict.fromkeys(MATCHES, lambda: {'methods': {'fpnet': MATCHED}, 'pairs': 500}),
    'sites': site_figures,
    'localization': localization,
    'peers': peers,
    'open': open_report,
    'drawings': lambda: DRAWINGS,
    **dict.fromkeys(('drawings_pdf', 'drawings_svg', 'drawings_dxf'), lambda: VECTORS),
    'stated_scales': lambda: SCALES,
    'demo': lambda: {'seeds': {'0': RUN, '1': RUN | {'wrong_poses': 2}}},
    'real_logs': lambda: {'logs': {'intel': {'nothing': RUN, 'unknown': NOTHING}}},
    'robot': robot,
    'drift': lambda: {'drives': [DRIVE]},
    'walks': lambda: {
        'walks': [],
        'odometries': {
            'gyro': WALK | {'localised': 20, 'wrong': 0, 'off': 1, 'median_m': 0.05},
            'scans': WALK | {'localised': 19, 'wrong': 0, 'off': 2, 'median_m': 0.07},
            'kiss_icp': WALK,
        },
        'log': {'scans': WALK | {'path': 1.1}, 'kiss_icp': WALK | {'path': 30.0}},
    },
    'doctor_faults': lambda: {
        'faults': {'stamps late': FAULTY, 'a loop in TF': FAULTY | {'first': 4, 'else': ''}},
        'named_always': 1,
        'good': 10,
        'alarms': 0,
    },
    'short_submaps': lambda: {'paths': {'one scan': SHORT, '15 m': SHORT | {'wrong': 0}}},
    'align_pairs': lambda: {
        'pairs': {'lab': ALIGNED, 'office': {'status': 'refused', 'reason': 'not placed'}},
    },
    'guidance': lambda: {
        'nowhere': 4,
        'policies': {
            'advice': EXPLORED,
            'nearest': EXPLORED,
            'random': EXPLORED | {'mean_m': 20.0},
        },
    },
    'clean_ends': lambda: {'when': {'running': ENDED, 'starting': ENDED | {'clean': 24}}},
    'faults': lambda: {'drives': [], 'faults': {'none': FAULT, 'gap': FAULT | NO_RECOVERY}},
    'carried_off': lambda: {'drives': [{}], 'ways': {'asked': CARRIED, 'not_asked': CARRIED}},
    'seeder': lambda: {'drives': [], 'totals': SEEDED},
    'speed': lambda: {'figures': {'match call': TIMED, 'a start': TIMED | {'aim_s': None}}},
    'wirings': lambda: {'robots': [WIRED, WIRED | {'twist_error': None}]},
    **dict.fromkeys(('node_load', 'node_load_kiss'), lambda: {'phases': {'25000 points': LOAD}}),
    'cloud_transport': lambda: {'points': 300_000, 'clouds': 50, 'cases': ARRIVED},
    'calibration': lambda: (
        {'half': 'report', 'kinds': {'real': RELIABLE | {'maps': 100}}} | RELIABLE
    ),
    'claim_rules': lambda: {'drives': 42, 'rules': [RULE, RULE | {'first_m': None}]},
    'scorer_ablation': lambda: {'judges': {'features alone': {'50-100 %': JUDGED}}},
    'long_run': lambda: HOUR,
    'sheet_drives': lambda: {'drives': ON_SHEETS},
    'two_programs': lambda: {'commit': 'abc1234', 'drives': [_two_programs()]},
    'finished_clouds': lambda: CLOUDS,
    'submap_losses': lambda: {'sensors': {'beams16': LOST, 'all': LOST}},
    'recordings': lambda: RECORDED,
    'simulator': lambda: MADE_PER_S,
    'statistics': lambda: STATISTICS,
    'constants_varied': lambda: VARIED,
    'growth': lambda: GROWTH,
    'readers': lambda: {'readers': [READ]},
    'wheels': lambda: WHEELS,
    **{name: partial(manifest, name) for name in WEIGHTS},
}


def rows(table):
    lines = [line for line in table.splitlines() if line.startswith('|')]
    return [[cell.strip() for cell in line.strip('|').split('|')] for line in lines]
