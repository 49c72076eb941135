# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Benchmark suite: building, sensor and kind of plan of each run.

The suite's seed determines everything. Generated buildings cycle through layout families, sensors
and plan groups at once; the three cycle lengths have no common factor, so that all combinations
are equally frequent.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import zip_longest

from fpnet_core.errors import ConfigError
from fpnet_lab.sim.plans import BUILDINGS

SYMMETRIC_FAMILIES = ('turned', 'mirrored')
REPEATED_FAMILY = 'repeated'
PLAIN_FAMILIES = tuple(
    name for name in BUILDINGS if name not in (*SYMMETRIC_FAMILIES, REPEATED_FAMILY)
)
"""Families without built-in symmetry or repetition, where the pose is unique."""

SENSOR_CYCLE = ('beams32', 'dome', 'beams16', 'planar', 'beams64')
WRONG_PLANS_PER_CASE = 5
"""Number of other buildings' plans tried on each plain building's recording. Chosen."""

MESHES = {
    'aws_small_house': 'meshes_tune',
    'cpr_office': 'meshes_tune',
    'willowgarage': 'meshes_report',
    'aws_hospital': 'meshes_report',
}
"""Meshes of real buildings and their splits."""

LOGS = ('intel', 'freiburg-079')
# Chosen, not measured:
_ROUNDS = 3  # buildings per plain family
_MESH_SEEDS = 3
_SYMMETRIC_ROUNDS, _REPEATED = 4, 6


class CaseKind(StrEnum):
    """Source of a case's scans."""

    GENERATED = 'generated'
    MESH = 'mesh'
    LOG = 'log'


class Distortion(StrEnum):
    """Difference between plan and building."""

    EXACT = 'exact'
    STRETCHED_5 = 'stretched_5'
    STRETCHED_10 = 'stretched_10'
    CHANGED_WALLS = 'changed_walls'
    SKETCH = 'sketch'
    UNKNOWN_SCALE = 'unknown_scale'


OPEN_SET_GROUPS = ('wrong_building', 'mirrored_plan')
"""Groups in which no pose is right and every accepted one is false."""

ROUGH_GROUP = 'rough'
"""Recordings of the plain buildings on rough drawings; they are excluded from totals."""

GROUPS = (
    *Distortion,
    ROUGH_GROUP,
    'symmetric',
    'repeated',
    *dict.fromkeys(MESHES.values()),
    'logs',
    *OPEN_SET_GROUPS,
)
"""Names of all groups in the report."""


@dataclass(frozen=True)
class Case:
    """
    One recording and its plan.

    ``building`` is a layout family, a mesh or a log; ``wrong_cases`` are numbers of plain cases
    whose plans are also tried on this recording. The flags add a mirrored and a rough plan.
    """

    name: str
    group: str
    kind: CaseKind
    building: str
    seed: int
    sensor: str = 'planar'
    distortion: Distortion = Distortion.EXACT
    wrong_cases: tuple[int, ...] = ()
    has_mirrored_plan: bool = False
    has_rough_plan: bool = False


def make_suite(seed: int = 0) -> tuple[Case, ...]:
    """Return all cases, alternating between groups, so that any prefix covers most groups."""
    plain = plain_cases(seed)
    groups: dict[str, list[Case]] = {}
    logs = [Case(name, 'logs', CaseKind.LOG, name, 0) for name in LOGS]
    for case in (*plain, *_adversarial(seed), *_meshes(), *logs):
        groups.setdefault(case.group, []).append(case)
    rounds = zip_longest(*groups.values())
    return tuple(case for cases in rounds for case in cases if case is not None)


def plain_cases(seed: int) -> tuple[Case, ...]:
    """Return the generated buildings without symmetry, in order of their numbers."""
    distortions = tuple(Distortion)
    count = _ROUNDS * len(PLAIN_FAMILIES)
    return tuple(
        Case(
            name=f'{PLAIN_FAMILIES[k % len(PLAIN_FAMILIES)]}-{k}',
            # The round shifts the cycle: six distortions and 14 families share a factor.
            group=distortions[(k + k // len(PLAIN_FAMILIES)) % len(distortions)],
            kind=CaseKind.GENERATED,
            building=PLAIN_FAMILIES[k % len(PLAIN_FAMILIES)],
            seed=_case_seed(seed, k),
            sensor=SENSOR_CYCLE[k % len(SENSOR_CYCLE)],
            distortion=distortions[(k + k // len(PLAIN_FAMILIES)) % len(distortions)],
            wrong_cases=_others(k, count),
            has_mirrored_plan=True,
            has_rough_plan=True,
        )
        for k in range(count)
    )


def select(
    suite: Iterable[Case], groups: Sequence[str] | None, limit: int | None
) -> tuple[Case, ...]:
    """
    Return the cases of some groups, at most ``limit``.

    An open-set or rough group selects the plain cases whose recordings it uses.

    Raises
    ------
    ConfigError
        If there is no such group.
    """
    unknown = set(groups or ()) - set(GROUPS)
    if unknown:
        raise ConfigError(f'unknown group {min(unknown)!r}; choose from {", ".join(GROUPS)}')
    chosen = [case for case in suite if groups is None or _is_wanted(case, groups)]
    return tuple(chosen[:limit])


def _is_wanted(case: Case, groups: Sequence[str]) -> bool:
    return case.group in groups or (
        ('wrong_building' in groups and bool(case.wrong_cases))
        or ('mirrored_plan' in groups and case.has_mirrored_plan)
        or (ROUGH_GROUP in groups and case.has_rough_plan)
    )


def _case_seed(seed: int, number: int) -> int:
    return 1000 * (seed + 1) + number


def _others(k: int, count: int) -> tuple[int, ...]:
    """Return numbers of other cases: the same family's next building, then other families."""
    steps = (len(PLAIN_FAMILIES), 1, 2, 5, 9)
    return tuple((k + step) % count for step in steps[:WRONG_PLANS_PER_CASE])


def _adversarial(seed: int) -> Iterable[Case]:
    """Yield symmetric buildings and buildings with one repeated room, with exact plans."""
    families = [*SYMMETRIC_FAMILIES * _SYMMETRIC_ROUNDS, *[REPEATED_FAMILY] * _REPEATED]
    for k, family in enumerate(families):
        yield Case(
            name=f'{family}-{k}',
            group='repeated' if family == REPEATED_FAMILY else 'symmetric',
            kind=CaseKind.GENERATED,
            building=family,
            seed=_case_seed(seed, 500 + k),
            sensor=SENSOR_CYCLE[k % len(SENSOR_CYCLE)],
        )


def _meshes() -> Iterable[Case]:
    for number in range(_MESH_SEEDS):
        for mesh, group in MESHES.items():
            if group == 'meshes_report' or number == 0:
                yield Case(
                    f'{mesh}-{number}', group, CaseKind.MESH, mesh, number, sensor='beams32'
                )
