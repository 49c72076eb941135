# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""When another localizer gets our pose: decisions on plain values, without ROS."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass, replace
from enum import StrEnum
import math

import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import wrap_to_pi
from fpnet_core.stamps import NS_PER_S
from fpnet_core.types import Status
from fpnet_ros.settings import SeederParameters
from msg_adapters.poses import UncertainPose

_GATE = 16.27
"""Given: 99.9 % quantile of the chi-squared distribution with three degrees of freedom."""

_SILENT = (
    'the other localizer publishes no pose while the robot moves: check its topic, or call ~/seed'
)
_MOST_DOUBLINGS = 4  # chosen: a seed that is ignored is repeated once in 16 times elsewhere_s
_SILENT_M = 3.0  # chosen: AMCL publishes after each 0.25 m
_MAX_AGE_S = 2.0  # chosen: an older pose of ours is not published


class PoseAgreement(StrEnum):
    """How the pose of the other localizer compares with ours."""

    UNKNOWN = 'unknown'
    TOGETHER = 'together'
    ELSEWHERE = 'elsewhere'
    UNSURE = 'unsure'


@dataclass(frozen=True, eq=False)
class Situation:
    """
    What is known at one time.

    ``status`` is our localizer's, ``ours`` its newest pose since it is localized. ``pair`` has our
    pose and the other localizer's at one stamp. ``is_heard``: somebody subscribes to the seeds.
    """

    now_ns: int
    status: Status | None = None
    ours: UncertainPose | None = None
    pair: tuple[UncertainPose, UncertainPose] | None = None
    is_heard: bool = True


@dataclass(frozen=True)
class SeedingState:
    """
    What the seeder remembers.

    ``is_new``: the other localizer has published no pose yet and gets ours as soon as there is
    one. ``agreement`` is the comparison that has lasted; ``apart`` the distance [m] and turn [rad]
    of the last one, ``apart_since_ns`` the stamp of the first of those in a row that disagree.
    ``seeds`` counts the seeds, ``in_vain`` those since both agreed; ``seeded_ns`` is the stamp of
    the last one. ``heard_at`` is our position [m] at the last seed or comparison.
    """

    is_new: bool = True
    agreement: PoseAgreement = PoseAgreement.UNKNOWN
    apart: tuple[float, float] = (0.0, 0.0)
    apart_since_ns: int | None = None
    seeded_ns: int | None = None
    seeds: int = 0
    in_vain: int = 0
    heard_at: tuple[float, float] | None = None

    @property
    def is_due(self) -> bool:
        """Whether the other localizer needs a seed."""
        return self.is_new or self.agreement in (PoseAgreement.ELSEWHERE, PoseAgreement.UNSURE)

    def has_heard(self) -> SeedingState:
        """Return the state after any pose of the other localizer: from now on it is compared."""
        return replace(self, is_new=False)

    def has_restarted(self) -> SeedingState:
        """Return the state after the other localizer was started again."""
        return SeedingState(seeds=self.seeds)

    def has_seeded(self, ours: UncertainPose) -> SeedingState:
        """Return the state after a seed."""
        return SeedingState(
            is_new=False,
            seeded_ns=ours.pose.stamp_ns,
            seeds=self.seeds + 1,
            in_vain=self.in_vain + 1,
            heard_at=_xy(ours),
        )


@dataclass(frozen=True)
class Advice:
    """Whether to publish the newest pose, and what to log once for each change of ``kind``."""

    seed: bool
    kind: str
    said: str
    is_trouble: bool = False


def advise(
    state: SeedingState, seen: Situation, limits: SeederParameters
) -> tuple[SeedingState, Advice]:
    """Return the next state and what to do; a pose of ours is refused unless it is sure."""
    if seen.status is not Status.LOCALIZED:
        state = replace(state, agreement=PoseAgreement.UNKNOWN, apart_since_ns=None, heard_at=None)
    elif seen.pair is not None:
        state = _compared(state, *seen.pair, limits)
    elif seen.ours is not None and state.heard_at is None:
        state = replace(state, heard_at=_xy(seen.ours))
    refusal = refused(seen, limits)
    if not refusal and not (state.is_new or limits.reseed):
        refusal = 'reseed is false; call ~/seed'
    if state.is_due and not refusal and seen.ours is not None:
        x, y = _xy(seen.ours)
        said = f'{_need(state)}; published the pose ({x:.2f}, {y:.2f})'
        kind = f'seed {state.seeds}'
        return state.has_seeded(seen.ours), Advice(True, kind, said, not state.is_new)
    return state, _described(state, seen, refusal)


def is_restart(before: Set[bytes], now: Set[bytes], is_new: bool) -> bool:
    """
    Return whether the other localizer was started again, from who subscribes to the seeds.

    A dead subscriber remains until its lease expires, so a new one beside it is a restart as well,
    unless the localizer ``is_new`` anyway.
    """
    return bool((before and not now) or (now - before and not is_new))


def refused(seen: Situation, limits: SeederParameters) -> str:
    """Return why our pose must not be published now; empty if it may."""
    if seen.status is not Status.LOCALIZED:
        return f'our localizer is {seen.status.value if seen.status else "silent"}'
    if seen.ours is None:
        return 'our localizer has not published its pose yet'
    age_s = (seen.now_ns - seen.ours.pose.stamp_ns) / NS_PER_S
    if abs(age_s) > _MAX_AGE_S:
        return f'the newest pose of our localizer is {age_s:.1f} s old'
    if (sigma_m := position_sigma(seen.ours.cov)) > limits.unsure_m:
        return f'our localizer is unsure by {sigma_m:.1f} m'
    return '' if seen.is_heard else 'nobody subscribes to initialpose'


def position_sigma(cov: NDArray[np.float64]) -> float:
    """Return the largest standard deviation of position [m] of ``cov (3, 3)`` of x, y, yaw."""
    return math.sqrt(max(float(np.linalg.eigvalsh(cov[:2, :2])[-1]), 0.0))


def _compared(
    state: SeedingState, ours: UncertainPose, other: UncertainPose, limits: SeederParameters
) -> SeedingState:
    """Return the state after comparing two poses of one stamp."""
    stamp_ns = other.pose.stamp_ns
    if state.seeded_ns is not None and stamp_ns <= state.seeded_ns:
        return state  # it does not know the seed yet
    here, there = ours.pose.T_frame_body, other.pose.T_frame_body
    apart = np.array([*(there.translation - here.translation), wrap_to_pi(there.yaw - here.yaw)])
    slack = np.diag(np.square([limits.tolerance_m, limits.tolerance_m, limits.tolerance_rad]))
    squared = float(apart @ np.linalg.solve(ours.cov + other.cov + slack, apart))
    found = PoseAgreement.TOGETHER if squared <= _GATE else PoseAgreement.ELSEWHERE
    if position_sigma(other.cov) > limits.unsure_m:
        found = PoseAgreement.UNSURE
    state = replace(
        state,
        is_new=False,
        apart=(float(np.hypot(*apart[:2])), abs(float(apart[2]))),
        heard_at=_xy(ours),
    )
    if found is PoseAgreement.TOGETHER:
        return replace(state, agreement=found, apart_since_ns=None, in_vain=0)
    since_ns = stamp_ns if state.apart_since_ns is None else state.apart_since_ns
    wait_s = limits.elsewhere_s * 2.0 ** min(state.in_vain, _MOST_DOUBLINGS)
    has_lasted = stamp_ns - since_ns >= wait_s * NS_PER_S
    return replace(
        state,
        apart_since_ns=since_ns,
        agreement=found if has_lasted else state.agreement,
    )


def _described(state: SeedingState, seen: Situation, refusal: str) -> Advice:
    """Return the advice not to publish, with the reason."""
    if state.is_due:
        kind = f'{state.agreement}, {seen.status}, {seen.is_heard}'
        said = f'{_need(state)}; no seed: {refusal}'
        return Advice(False, kind, said, is_trouble=not state.is_new)
    if seen.status is not Status.LOCALIZED:
        return Advice(False, f'{seen.status}', refusal)
    moved_m = math.dist(_xy(seen.ours), state.heard_at) if seen.ours and state.heard_at else 0.0
    if moved_m > _SILENT_M:
        return Advice(False, 'silent', _SILENT, is_trouble=True)
    if state.agreement is PoseAgreement.TOGETHER:
        return Advice(False, 'together', 'the other localizer agrees')
    return Advice(False, 'waiting', 'waiting for a pose of the other localizer')


def _need(state: SeedingState) -> str:
    if state.agreement is PoseAgreement.UNKNOWN:
        return 'the other localizer has no pose yet'
    metres, radians = state.apart
    return (
        f'the other localizer is {state.agreement}, off by {metres:.1f} m and '
        f'{math.degrees(radians):.0f} degrees'
    )


def _xy(pose: UncertainPose) -> tuple[float, float]:
    x, y = pose.pose.T_frame_body.translation.tolist()
    return x, y
