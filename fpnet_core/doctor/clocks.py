# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks of clocks and stamps: jumps, different clocks, and low rates."""

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
_BACK_S = 0.1  # a larger step back is not caused by messages out of order
_AHEAD_S = 1.0  # smallest skip of stamps beyond the step of arrival times
_APART_S = 1.0  # clocks further apart differ; transforms are post-dated by up to half of it
_LONG_S = 1e4  # longer times are printed with three digits


def check_jumps(seen: Observed) -> Iterator[Finding]:
    """Yield topics (scans, odometry) whose clock goes back or skips."""
    for topic in filter(None, map(seen.topic, dict.fromkeys((seen.scans, seen.odometry)))):
        steps_s = np.diff(topic.stamps_ns) / NS_PER_S
        skips_s = steps_s - np.diff(topic.heard_ns) / NS_PER_S
        back = np.flatnonzero(steps_s < -_BACK_S)
        ahead = np.flatnonzero(skips_s > _AHEAD_S)
        if len(back):
            jump = f'goes back by {-steps_s[back[0]]:.2f} s at message {back[0] + 1}'
            fix = (
                'is a recording looping, or do two publishers share the topic (ros2 topic info '
                '-v)? Odometry and submap restart at every step back'
            )
            yield Finding(Problem.CLOCK_JUMP, topic.name, f'its clock {jump}{_more(back)}', fix)
        elif len(ahead):
            jump = f'skips {skips_s[ahead[0]]:.2f} s at message {ahead[0] + 1}'
            fix = (
                'was the clock set while recording (NTP, PTP)? Start the drivers after the clock '
                'is synchronized, or stamp by a monotonic clock'
            )
            yield Finding(Problem.CLOCK_JUMP, topic.name, f'its clock {jump}{_more(ahead)}', fix)


def check_gaps(seen: Observed) -> Iterator[Finding]:
    """Yield odometry whose poses are usually too far apart in time to be interpolated."""
    topic = seen.topic(seen.odometry)
    steps_ns = np.diff(np.unique(topic.stamps_ns)) if topic is not None else np.zeros(0)
    if len(steps_ns) and np.median(steps_ns) > MAX_GAP_NS:
        yield Finding(
            Problem.SPARSE,
            seen.odometry,
            f'a pose every {np.median(steps_ns) / NS_PER_S:.1f} s; scans between poses more than '
            f'{MAX_GAP_NS / NS_PER_S} s apart are skipped',
            'publish it at 10 Hz or more (is it throttled?); until then use KISS-ICP (fpnet '
            'localize --odometry kiss)',
        )


def check_rate(seen: Observed) -> Iterator[Finding]:
    """Yield scans whose rate is too low for scan matching, if there is no other odometry."""
    topic = seen.topic(seen.scans)
    if topic is None or len(seen.track) or is_registered(seen.scans):
        return
    steps_ns = np.diff(np.unique(topic.stamps_ns))
    if len(steps_ns) and (rate_hz := NS_PER_S / float(np.median(steps_ns))) < FEWEST_HZ:
        yield Finding(
            Problem.RARE,
            topic.name,
            f'{rate_hz:.1f} Hz, and no other odometry: scan matching needs {FEWEST_HZ:.0f} Hz or '
            'more when the robot turns',
            'publish all scans (is the topic throttled, or the network overloaded?), or publish '
            'odometry as well (odometry:=both)',
        )


def _more(found: np.ndarray) -> str:
    return '' if len(found) == 1 else f', and {len(found) - 1} more times'


def check_clocks(seen: Observed) -> Iterator[Finding]:
    """Yield topics stamped by another clock than that of the scans or of the nodes."""
    scans = seen.topic(seen.scans)
    if scans is None or not len(scans):
        return
    if not scans.stamps_ns.any():
        yield Finding(
            Problem.OTHER_CLOCK,
            scans.name,
            'its stamps are all zero',
            'let the driver stamp its scans; until then recordings use the times of arrival',
        )
        return
    if seen.is_live and abs(scans.lag_s) > _APART_S:
        yield Finding(
            Problem.OTHER_CLOCK,
            scans.name,
            f'{_offset_text(scans.lag_s)} the clock of the nodes',
            'with a recording or a simulator set use_sim_time: true and publish /clock (ros2 bag '
            'play --clock); on a robot let the driver use the system clock, or synchronize the '
            'clock of the sensor (PTP)',
        )
    for other in filter(None, map(seen.topic, (seen.odometry, seen.tf))):
        offset_s = _offset_s(other, scans)
        if abs(offset_s) > _APART_S:
            yield Finding(
                Problem.OTHER_CLOCK,
                other.name,
                f'{_offset_text(offset_s)} those of {scans.name}',
                'stamp both by one clock: the time of the host (driver option use_system_time or '
                'similar), or a sensor clock that is synchronized by PTP or NTP',
            )


def _offset_s(other: Topic, scans: Topic) -> float:
    """Return how much older other stamps are than the scans' at equal times of arrival [s]."""
    return other.lag_s - scans.lag_s if len(other) else 0.0


def _offset_text(seconds: float) -> str:
    size = f'{abs(seconds):.1f} s' if abs(seconds) < _LONG_S else f'{abs(seconds):.3g} s'
    return f'its stamps are {size} {"behind" if seconds > 0.0 else "ahead of"}'
