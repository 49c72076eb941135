# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of the reports on running nodes, robot wirings and load."""

from __future__ import annotations

from typing import Any

from fpnet_lab.scores import Column, Figures, Row, Table, Unit, Units, named, together

_ERROR = together(('error_m', Units.METRES), ('error_deg', Units.DEGREES))


def _lost(row: Row) -> str:
    return f'{sum(row["lost"].values()):.0f} of {row["sweeps"]}'


def _velocity(row: Row) -> str | None:
    if row['twist_error'] is None:
        return None
    speed_mps, turn_radps = row['twist_error']
    return f'{Unit(" m/s", 2).text(speed_mps)}, {Unit(" rad/s", 2).text(turn_radps)}'


_WIRINGS = (
    Column('robot', 'robot'),
    Column('first pose', 'first_pose_s', Units.SECONDS),
    Column('median error', _ERROR),
    Column('of the bag', 'offline_error_m', Units.METRES),
    Column('TF', 'tf_error_m', Units.METRES),
    Column('velocity', _velocity),
    Column('scans lost', _lost),
)
_FAULTS = (
    Column('robot', 'name'),
    Column('is', 'is'),
    Column('named first', lambda row: f'{row["first"]} of {row["drives"]}'),
    Column('alone', 'alone'),
    Column('else first', 'else'),
)
_SEEDER = (
    Column('robots carried off', 'kidnaps'),
    Column('initialized again', 'reseeded'),
    Column('after, median and most', together(
        ('reseeded_s_median', Units.SECONDS), ('reseeded_s_max', Units.SECONDS)
    )),
    Column('filter right at the end', 'right_at_the_end'),
    Column('seeds', 'seeds'),
    Column('wrong', 'wrong_seeds'),
)  # fmt: skip
_SEED_COVARIANCES = (  # numerical: digits
    Column('drawing', 'name'),
    Column('first poses', 'first_poses'),
    Column('inside 95 %', 'inside_95', Units.SHARE.to(1)),
    Column('NEES', 'nees_mean', Units.NUMBER.to(1)),
)
_MIB = Unit(' MiB')
_LOAD = (
    ('scans lost', lambda phase: f'{phase["scans_lost"]:.0f} of {phase["scans_sent"]}'),
    ('TF jitter, largest', together(('tf_jitter_max', Units.MS))),
    ('service call, 99th percentile', together(('call_p99', Units.MS))),
    ('tick, median and 99th percentile', together(('tick_p50', Units.MS), ('tick_p99', Units.MS))),
    ('pose behind its scan, largest', together(('pose_behind_max_s', Units.SECONDS.to(2)))),
    ('memory', together(('memory_mib', _MIB))),
    (
        'its growth over the second half',
        together(('memory_growth_second_half_percent', Unit(' %', 1))),
    ),
)  # numerical: digits


_PROFILES = {'defaults': 'defaults', 'fastdds_shm.xml': '`fastdds_shm.xml`'}


def cloud_transport(report: Row) -> Figures:
    """Return a row for each profile: number of received clouds and latency by subscription."""
    subscriptions = list(dict.fromkeys(case['subscription'] for case in report['cases']))
    rows = [
        [title, *(_arrived(report, profile, each) for each in subscriptions)]
        for profile, title in _PROFILES.items()
    ]
    what = f'of {report["clouds"]} clouds of {report["points"]:,} points'
    return {'': Table((what, *subscriptions), rows)}, {}


def _arrived(report: Row, profile: str, subscription: str) -> str:
    """Return the number of received clouds and their median latency for one setup."""
    for case in report['cases']:
        if (case['profile'], case['subscription']) == (profile, subscription):
            late = Units.MS.to(0, 'none').text(case['latency_ms'])
            return f'{case["arrived"]}, {late}'
    return ''


def wirings(report: Row) -> Figures:
    """Return a row for each robot wiring."""
    return {'': Table.of(_WIRINGS, report['robots'])}, {}


def node_load(report: Row) -> Figures:
    """Return a column for each phase of the load test."""
    phases: dict[str, Any] = report['phases']
    titles = [f'{name}, {_minutes(phase)}' for name, phase in phases.items()]
    rows = [[figure, *(text(phase) for phase in phases.values())] for figure, text in _LOAD]
    return {'': Table(['figure', *titles], rows)}, {}


def _minutes(phase: Row) -> str:
    """Return the duration of a phase from its scans, ten per second."""
    return f'{phase["scans_sent"] / 600.0:g} min'


def seeder(report: Row) -> Figures:
    """Return what the seeder told robots that were carried off, and how well seeds fit."""
    totals = report['totals']
    drawings = named({name: totals[name] for name in ('exact', 'sketch')})
    tables = {
        '': Table.of(_SEEDER, [totals]),
        'covariance': Table.of(_SEED_COVARIANCES, drawings),
    }
    return tables, {'wrong_first_poses': str(totals['wrong_first_poses'])}


def doctor_faults(report: Row) -> Figures:
    """Return the faults detected by the doctor, and its false alarms."""
    figures = {
        'always': f'{report["named_always"]} of {len(report["faults"])}',
        'alarms': f'{report["alarms"]} of {report["good"]}',
    }
    return {'': Table.of(_FAULTS, named(report['faults']))}, figures
