# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Clocks that jump, stamps of different clocks, and stamps too far apart."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fpnet_core.doctor.findings import Finding, Problem
from fpnet_core.doctor.observed import Observed, Topic
from fpnet_core.geometry.pose_track import MAX_GAP_NS
from fpnet_core.io.topic_names import is_registered
from fpnet_core.scoring.findings import FEWEST_HZ
from fpnet_core.stamps import NS_PER_S

# Chosen, not measured:
_BACK_S = 0.1  # a scan that is so much older than the last one is no disorder on the way
_AHEAD_S = 1.0  # stamps that skip so much more than arrival does
_APART_S = 1.0  # clocks further apart differ; transforms are post-dated by up to half of it
_LONG_S = 1e4  # nobody wants to read the digits of more


def check_jumps(seen: Observed) -> Iterator[Finding]:
    """Yield where the clock of scans or odometry goes back, or skips."""
    for topic in filter(None, map(seen.topic, dict.fromkeys((seen.scans, seen.odometry)))):
        steps_s = np.diff(topic.stamps_ns) / NS_PER_S
        skips_s = steps_s - np.diff(topic.heard_ns) / NS_PER_S
        back = np.flatnonzero(steps_s < -_BACK_S)
        ahead = np.flatnonzero(skips_s > _AHEAD_S)
        if len(back):
            said = f'goes back by {-steps_s[back[0]]:.2f} s at message {back[0] + 1}'
            fix = (
                'is a recording looping, or do two publishers share the topic (ros2 topic info '
                '-v)? Odometry and submap begin anew at every step back'
            )
            yield Finding(Problem.CLOCK_JUMP, topic.name, f'its clock {said}{_more(back)}', fix)
        elif len(ahead):
            said = f'skips {skips_s[ahead[0]]:.2f} s at message {ahead[0] + 1}'
            fix = (
                'was the clock set while recording (NTP, PTP)? Start the drivers after the clock '
                'is right, or stamp by a clock that nobody sets'
            )
            yield Finding(Problem.CLOCK_JUMP, topic.name, f'its clock {said}{_more(ahead)}', fix)


def check_gaps(seen: Observed) -> Iterator[Finding]:
    """Yield odometry whose poses mostly are too far apart to be interpolated."""
    topic = seen.topic(seen.odometry)
    steps_ns = np.diff(np.unique(topic.stamps_ns)) if topic is not None else np.zeros(0)
    if len(steps_ns) and np.median(steps_ns) > MAX_GAP_NS:
        yield Finding(
            Problem.SPARSE,
            seen.odometry,
            f'a pose every {np.median(steps_ns) / NS_PER_S:.1f} s; scans between poses more than '
            f'{MAX_GAP_NS / NS_PER_S} s apart are left out',
            'publish it at 10 Hz or more (is it throttled?); meanwhile use KISS-ICP (fpnet '
            'localize --odometry kiss)',
        )


def check_rate(seen: Observed) -> Iterator[Finding]:
    """Yield scans that alone are to tell the motion, and come too rarely to be matched."""
    topic = seen.topic(seen.scans)
    if topic is None or len(seen.track) or is_registered(seen.scans):
        return
    steps_ns = np.diff(np.unique(topic.stamps_ns))
    if len(steps_ns) and (rate_hz := NS_PER_S / float(np.median(steps_ns))) < FEWEST_HZ:
        yield Finding(
            Problem.RARE,
            topic.name,
            f'{rate_hz:.1f} a second, and no other odometry: matching them takes '
            f'{FEWEST_HZ:.0f} or more where a robot turns',
            'publish all scans (is the topic throttled, or the network full?), or odometry as '
            'well (odometry:=both)',
        )


def _more(found: np.ndarray) -> str:
    return '' if len(found) == 1 else f', and {len(found) - 1} times more'


def check_clocks(seen: Observed) -> Iterator[Finding]:
    """Yield topics that are stamped by another clock than the scans, or than the nodes follow."""
    scans = seen.topic(seen.scans)
    if scans is None or not len(scans):
        return
    if not scans.stamps_ns.any():
        yield Finding(
            Problem.OTHER_CLOCK,
            scans.name,
            'its stamps are all zero',
            'let the driver stamp its scans; a recording is then taken at the times of arrival',
        )
        return
    if seen.is_live and abs(scans.lag_s) > _APART_S:
        yield Finding(
            Problem.OTHER_CLOCK,
            scans.name,
            f'{_apart(scans.lag_s)} the clock that the nodes follow',
            'with a recording or a simulator set use_sim_time: true and publish /clock (ros2 bag '
            "play --clock); on a robot let the driver stamp by the system's clock, or set the "
            "sensor's (PTP)",
        )
    for other in filter(None, map(seen.topic, (seen.odometry, seen.tf))):
        apart_s = _apart_s(other, scans)
        if abs(apart_s) > _APART_S:
            yield Finding(
                Problem.OTHER_CLOCK,
                other.name,
                f'{_apart(apart_s)} those of {scans.name}',
                'both have to be stamped by one clock: the time of the host (driver option '
                'use_system_time or similar), or a sensor clock that is set by PTP or NTP',
            )


def _apart_s(other: Topic, scans: Topic) -> float:
    """Return by how much other stamps are older than the scans' at the same time of arrival."""
    return other.lag_s - scans.lag_s if len(other) else 0.0


def _apart(seconds: float) -> str:
    size = f'{abs(seconds):.1f} s' if abs(seconds) < _LONG_S else f'{abs(seconds):.3g} s'
    return f'its stamps are {size} {"behind" if seconds > 0.0 else "ahead of"}'
