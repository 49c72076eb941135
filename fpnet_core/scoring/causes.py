# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Likely causes of a run without a pose, most likely first, each with numbers and a command to run.

A reason (:mod:`fpnet_core.scoring.reasons`) states what decided one update; a cause is something
that a user can act on. Causes that were tested come first: if the plan fits once it is flipped or
rescaled, no further explanation is needed.
"""

from __future__ import annotations

from collections.abc import Iterator
import math

from fpnet_core.scoring.findings import (
    FEWEST_HZ,
    LIKELY,
    POSSIBLE,
    PROVED,
    DoubleWalls,
    Findings,
    Fit,
    TurningWalls,
)
from fpnet_core.scoring.invocation import Invocation
from fpnet_core.scoring.reasons import (
    AS_WELL,
    AT_EDGE,
    EXPLAINED_WELL,
    FEW_WALLS_M,
    metres,
    percent,
)
from fpnet_core.types import Cause, CauseKind

_STANDSTILL_M = 0.5  # physical: a robot that drove less has observed from one place only
_MANY_RESTARTS = 3  # chosen: a single one may be an odometry node that was restarted
_SAME_SCALE = 0.03  # chosen: a scale that differs by less would have been found by the search

_TESTED = 0.97
"""Chosen: lowest weight of a cause confirmed by a test."""

_SIDE_FINDING = 0.4  # chosen: weight of a finding that is true but explains nothing

_UPSIDE_DOWN = '; a scanner mounted upside down has the same effect if /tf_static has it upright'
_WEIGHTS = {CauseKind.DRAWING: 0.95, CauseKind.TOO_LITTLE: 0.85}  # chosen


def causes_of(found: Findings, invocation: Invocation | None = None) -> tuple[Cause, ...]:
    """Return the likely causes, most likely first; at least one."""
    invocation = invocation or Invocation()
    weighed = [each for of in _EVERY for each in of(found, invocation)]
    ranked = sorted(weighed, key=lambda each: (-each[0], _LISTED[each[1].kind]))
    if ranked and ranked[0][0] >= _TESTED:
        # A confirmed cause leaves nothing for guesses to explain.
        ranked = [ranked[0], *(each for each in ranked[1:] if each[1].kind not in _GUESSES)]
    return tuple(cause for _, cause in ranked) or (_undecided(found, invocation),)


_Weighed = Iterator[tuple[float, Cause]]


def _drawing(found: Findings, invocation: Invocation) -> _Weighed:
    if found.doubts:
        look = invocation.look_at_reading()
        evidence = '; '.join(doubt.rstrip('.') for doubt in found.doubts)
        yield _WEIGHTS[CauseKind.DRAWING], Cause(CauseKind.DRAWING, evidence, look)


def _scale(found: Findings, invocation: Invocation) -> _Weighed:
    fit = found.rescaled
    low, high = found.scales
    if found.scale_conflict is not None and (fit is None or fit.probability < PROVED):
        said = found.scale_conflict.said_at(found.resolution_m)
        evidence = f'{said}; {found.resolution_m:.3g} was used'
        once = invocation.again('--set', 'localizer.scale_policy=unknown')
        yield _TESTED, Cause(CauseKind.SCALE, evidence, once)
    elif fit is not None:
        is_outside = not low * (1.0 - _SAME_SCALE) <= fit.scale <= high * (1.0 + _SAME_SCALE)
        if is_outside and fit.probability >= POSSIBLE and _explains_more(fit, found):
            yield _tested(fit.probability), _scale_found(found, fit, invocation)
    if found.scale_conflict is not None or fit is not None:
        return
    best, edge = found.best, 1.0 + AT_EDGE
    if best is None or not 0.0 < low * edge**2 < high < math.inf:
        return
    if low * edge < best.scale < high / edge:
        return
    limit = 'lowest' if best.scale <= low * edge else 'highest'
    evidence = (
        f'best fit at {best.scale:.2f} times the stated scale, the {limit} searched '
        f'({low:.2f} to {high:.2f})'
    )
    once = invocation.again('--set', 'localizer.scale_policy=unknown')
    yield 0.3, Cause(CauseKind.SCALE, evidence, once)


def _scale_found(found: Findings, fit: Fit, invocation: Invocation) -> Cause:
    low, high = found.scales
    evidence = (
        f'{percent(fit.explained)} of {metres(found.walls_m)} of observed wall fit at '
        f'{fit.scale:.2f} times the scale used (p {fit.probability:.2f}); the search covered '
        f'{low:.2f} to {high:.2f}'
    )
    if not found.says_scale:
        again = invocation.again('--set', 'localizer.scale_policy=unknown')
        return Cause(CauseKind.SCALE, evidence, again)
    fitting_m = found.resolution_m / fit.scale
    evidence += f', and {fitting_m:.3g} m per pixel would fit'
    once = invocation.again('--resolution', f'{fitting_m:.3g}', instead_of=('--length',))
    return Cause(CauseKind.SCALE, evidence, once)


def _mirrored(found: Findings, invocation: Invocation) -> _Weighed:
    fit = found.mirror
    if found.sensed.is_upside_down:
        evidence = 'the floor is above it, so its scans are mirrored'
        yield 1.0, Cause(CauseKind.UPSIDE_DOWN, evidence, invocation.doctor())
        return
    if fit is None:
        if found.is_mirrored:
            evidence = f'the observations fit only the mirrored floorplan{_UPSIDE_DOWN}'
            yield 1.0, Cause(CauseKind.MIRRORED, evidence, invocation.flipped())
        return
    drawn = found.best.probability if found.best else 0.0
    if fit.probability < POSSIBLE:
        return
    is_better = fit.probability > drawn and _explains_more(fit, found)
    if not is_better and not found.is_mirrored:
        return
    explained = found.best.explained if found.best else 0.0
    evidence = (
        f'the mirror image explains {percent(fit.explained)} of {metres(found.walls_m)} of '
        f'observed wall (p {fit.probability:.2f}), the plan {percent(explained)}{_UPSIDE_DOWN}'
    )
    weight = 1.0 if found.is_mirrored else _tested(fit.probability)
    yield weight, Cause(CauseKind.MIRRORED, evidence, invocation.flipped())


def _other_plan(found: Findings, invocation: Invocation) -> _Weighed:
    explained = found.best.explained if found.best else 0.0
    if found.walls_m < FEW_WALLS_M or explained >= EXPLAINED_WELL:
        return
    if found.is_ambiguous or found.storeys_alike or found.sensed.are_rare:
        return
    tried = [
        *(['at other scales'] if found.rescaled else []),
        *(['mirrored'] if found.mirror else []),
    ]
    nor = f'; it does not fit {" or ".join(tried)} either' if tried else ''
    evidence = (
        f'the best placement explains {percent(explained)} of {metres(found.walls_m)} of observed '
        f'wall (a correct one: {percent(EXPLAINED_WELL)} or more){nor}'
    )
    if found.early is not None and found.has_drifted_later:
        evidence += f'; of the first metres, before drift, {percent(found.early.explained)}'
    again = invocation.on('OTHER_PLAN')
    if found.storeys > 1:
        evidence += f'; the sheet contains {found.storeys} storeys'
        again = invocation.again('--storey', str(1 if found.storey != 1 else 2))
    missing = min(1.0, (EXPLAINED_WELL - explained) / 0.3)
    weight = (0.6 if found.has_seen_much else 0.35) + 0.2 * missing
    yield weight, Cause(CauseKind.OTHER_PLAN, evidence, again)


def _input(found: Findings, invocation: Invocation) -> _Weighed:
    if found.is_blind:
        evidence = 'scans are received, but no return is a wall within range'
        yield 1.0, Cause(CauseKind.INPUT, evidence, invocation.doctor())
    elif found.sensed.are_rare:
        evidence = (
            f'{found.sensed.matched_hz:.1f} scans per second, and no other odometry: scan '
            f'matching needs {FEWEST_HZ:.0f} or more while the robot turns'
        )
        poses = invocation.again('--poses', 'POSES.tum')
        again = f'record all scans, or odometry as well, or provide poses: {poses}'
        yield 0.88, Cause(CauseKind.RARE_SCANS, evidence, again)


def _too_little(found: Findings, invocation: Invocation) -> _Weighed:
    if found.is_blind:
        return
    if found.driven_m < _STANDSTILL_M:
        evidence = (
            f'the robot stood still ({found.driven_m:.1f} m driven): {metres(found.walls_m)} of '
            f'wall and {round(found.seen_m2)} m² observed from one place'
        )
        yield 1.0, Cause(CauseKind.TOO_LITTLE, evidence, _drive_on(invocation))
        return
    if found.seen_m2 < found.needed_m2:
        evidence = (
            f'{math.floor(found.seen_m2)} m² of floor observed, and the first update needs '
            f'{math.ceil(found.needed_m2)} m²'
        )
        yield 1.0, Cause(CauseKind.TOO_LITTLE, evidence, _drive_on(invocation))
        return
    if found.has_seen_much:
        return
    of = f' of the {round(found.plan_m2)} m² on the plan' if found.plan_m2 else ''
    evidence = f'{metres(found.walls_m)} of wall and {round(found.seen_m2)} m²{of} observed'
    weight = _WEIGHTS[CauseKind.TOO_LITTLE] if found.walls_m < FEW_WALLS_M else 0.5
    yield weight, Cause(CauseKind.TOO_LITTLE, evidence, _drive_on(invocation))


def _drift(found: Findings, invocation: Invocation) -> _Weighed:
    if found.sensed.are_rare:  # the cause of the drift
        return
    better = invocation.again(
        *(('--odometry', 'both') if invocation.of_bag else ('--poses', 'POSES.tum'))
    )
    drift = found.drift
    if isinstance(drift, DoubleWalls):
        evidence = (
            f'walls revisited after {metres(drift.path_m)} are displaced by {drift.shift_m:.1f} m '
            f'and {drift.turn_deg:.0f} degrees ({percent(drift.before)} of them agree with the '
            f'first pass, {percent(drift.after)} after correction)'
        )
        yield _drift_weight(found, 0.84), Cause(CauseKind.DRIFT, evidence, better)
    elif isinstance(drift, TurningWalls):
        evidence = (
            f'the wall direction turns steadily, by {drift.turn_deg:.0f} degrees over '
            f'{metres(drift.path_m)}: a round building, or heading drift'
        )
        yield _drift_weight(found, 0.82), Cause(CauseKind.DRIFT, evidence, better)
    elif found.restarts - found.contradictions >= _MANY_RESTARTS:
        evidence = (
            f'the submap was restarted {found.restarts} times: odometry jumps or flips, or a '
            'clock goes back'
        )
        yield 0.86, Cause(CauseKind.DRIFT, evidence, invocation.doctor())
    elif found.contradictions:
        evidence = f'in {found.contradictions} updates the newest scans contradicted the pose'
        yield 0.81, Cause(CauseKind.DRIFT, evidence, better)


def _drift_weight(found: Findings, weight: float) -> float:
    """Return the weight of drift; low if the placement did not fit before the drift either."""
    return _SIDE_FINDING if found.has_drifted_later else weight


def _self_similar(found: Findings, invocation: Invocation) -> _Weighed:
    if found.storeys_alike:
        listed = ', '.join(f'{name} (p {p:.2f})' for name, p in found.storeys_alike.items())
        evidence = f'the observations do not separate these storeys: {listed}'
        known = f'drive to where they differ, or select one: {invocation.on_one_storey()}'
        yield 0.8, Cause(CauseKind.SELF_SIMILAR, evidence, known)
    if not found.is_ambiguous:
        return
    shares = ', '.join(percent(share) for share in found.alike[:4])
    more = f' and {len(found.alike) - 4} more' if len(found.alike) > 4 else ''
    evidence = (
        f'{len(found.alike)} places explain the {metres(found.walls_m)} of observed wall equally '
        f'well: {shares}{more}'
    )
    look = (
        f'{invocation.look("check-plan", "--plot", "alike.png")}, then drive to where rooms differ'
    )
    yield 0.55 if found.has_seen_much else 0.45, Cause(CauseKind.SELF_SIMILAR, evidence, look)


def _undecided(found: Findings, invocation: Invocation) -> Cause:
    """Return the cause if no finding contradicts the plan."""
    explained = f'{percent(found.best.explained)} of ' if found.best else ''
    evidence = f'no finding contradicts the plan, and {explained}{metres(found.walls_m)} of wall '
    evidence += 'fit: more observations would decide'
    return Cause(CauseKind.TOO_LITTLE, evidence, _drive_on(invocation))


def _drive_on(invocation: Invocation) -> str:
    return f'drive through at least two rooms and a corridor, then: {invocation.again()}'


def _explains_more(fit: Fit, found: Findings) -> bool:
    """Return whether a fit explains more than the search as configured did."""
    return found.best is None or fit.explained >= found.best.explained + AS_WELL


def _tested(probability: float) -> float:
    """Return the weight of a tested cause by the ``probability`` of the resulting fit."""
    if probability >= PROVED:
        return _TESTED + (1.0 - _TESTED) * probability
    return 0.75 if probability >= LIKELY else 0.3


_GUESSES = (CauseKind.OTHER_PLAN, CauseKind.SELF_SIMILAR, CauseKind.TOO_LITTLE)
_EVERY = (_drawing, _scale, _mirrored, _other_plan, _input, _too_little, _drift, _self_similar)
_LISTED = {kind: place for place, kind in enumerate(CauseKind)}
