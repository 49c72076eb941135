# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Runs of one case: localizer, baselines and other buildings' plans on one recording."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fpnet_core.config import FpnetConfig, parse_config
from fpnet_core.types import GridMap
from fpnet_lab.evaluation.localization.cases import ROUGH_GROUP, Case, CaseKind, plain_cases
from fpnet_lab.evaluation.localization.drives import ProductRun, Registrar, run_product
from fpnet_lab.evaluation.localization.figures import PRODUCT
from fpnet_lab.evaluation.localization.inputs import (
    CaseInputs,
    make_inputs,
    make_plan,
    make_rough_plan,
)
from fpnet_lab.evaluation.localization.records import (
    SCORED_AT_M,
    MethodRun,
    Record,
    RunLabels,
    Truth,
    belief_errors,
    score,
)
from fpnet_lab.evaluation.localization.rivals import run_rivals

UPDATE_PERIOD_S = 2.0
"""Sensor time between updates, equal for wrong plans: as many chances to accept. Chosen."""

LOG_UPDATE_PERIOD_S = 10.0
"""The same for the real logs, which last up to 45 minutes. Chosen."""

GROUP_SETTINGS: dict[str, dict[str, dict[str, Any]]] = {
    'stretched_10': {'pose': {'scale_tolerance': 0.15, 'anisotropy_sigma': 0.05}},
    'unknown_scale': {'localizer': {'scale_policy': 'unknown'}, 'pose': {'scale_tolerance': 0.5}},
    'logs': {'pose': {'scale_tolerance': 0.25, 'anisotropy_sigma': 0.05}},
}
"""User settings for plans of uncertain scale. Chosen."""


@dataclass(frozen=True)
class Job:
    """
    A case and how to run it; ``suite_seed`` numbers the other buildings' plans.

    ``clouds`` are the baselines that need additional packages.
    """

    case: Case
    config: FpnetConfig
    suite_seed: int
    data: Path
    with_baselines: bool = True
    strip: Path | None = None
    clouds: tuple[str, ...] = ()


def run_case(job: Job) -> tuple[Record, ...]:
    """
    Run a case and score every run on its recording.

    Raises
    ------
    MissingDataError
        If it needs real data that are missing.
    FpnetError
        If a plan or the weights cannot be used.
    """
    case, config = job.case, settings_of(job.case, job.config)
    inputs = make_inputs(case, job.data)
    registrar = Registrar(config.odometry)
    period_s = LOG_UPDATE_PERIOD_S if case.kind is CaseKind.LOG else UPDATE_PERIOD_S
    product = run_product(registrar.follow(inputs.scans), inputs.plan, config, period_s)
    truth = _truth(case, inputs)
    records = [score(_labels(case, PRODUCT), product.run, truth)]
    if job.with_baselines:
        records += _baseline_records(case, product, registrar, job, truth)
    if job.strip is not None:
        _draw_strip(job.strip, case, product, truth)
    del product
    if case.has_rough_plan:
        records.append(_on_rough_plan(job, registrar, inputs))
    for index, (name, group, plan) in enumerate(_false_plans(job, inputs)):
        false_case = replace(case, group=group)
        product = run_product(registrar.kept, plan, config, UPDATE_PERIOD_S)
        records.append(score(_labels(false_case, PRODUCT, name), product.run, None))
        if job.with_baselines and index == 0:
            records += _baseline_records(false_case, product, registrar, job, None, name)
    return tuple(records)


def _on_rough_plan(job: Job, registrar: Registrar, inputs: CaseInputs) -> Record:
    """Run the localizer on the recording's kept scans and a rough drawing of the building."""
    case = replace(job.case, group=ROUGH_GROUP)
    rough = make_rough_plan(case)
    product = run_product(registrar.kept, rough.grid, job.config, UPDATE_PERIOD_S)
    truth = Truth(inputs.truth, rough.A_plan_building, SCORED_AT_M)
    return score(_labels(case, PRODUCT, f'{case.name} {ROUGH_GROUP}'), product.run, truth)


def settings_of(case: Case, config: FpnetConfig) -> FpnetConfig:
    """Return the configuration with the settings of the case's group on the plan's scale."""
    tree = config.model_dump()
    for section, values in GROUP_SETTINGS.get(case.group, {}).items():
        tree[section] |= values
    return parse_config(tree, f'group {case.group}')


def _draw_strip(path: Path, case: Case, product: ProductRun, truth: Truth) -> None:
    from fpnet.viz.strip import plot_strip  # loads matplotlib

    plot_strip(
        path,
        product.plan.segmentation,
        product.replay.outputs,
        truth.poses.mapped(truth.A_plan_truth),
        [error and error[0] for error in belief_errors(product.run, truth)],
        f'{case.name}: {case.group}, {case.sensor}, seed {case.seed}',
    )


def _truth(case: Case, inputs: CaseInputs) -> Truth:
    judged_at_m = SCORED_AT_M if case.kind is CaseKind.GENERATED else float('inf')
    return Truth(inputs.truth, inputs.A_plan_truth, judged_at_m)


def _labels(case: Case, method: str, plan: str = '') -> RunLabels:
    return RunLabels(
        case.name, case.group, case.building, case.sensor, case.seed, method, plan or case.name
    )


def _baseline_records(
    case: Case,
    product: ProductRun,
    registrar: Registrar,
    job: Job,
    truth: Truth | None,
    plan: str = '',
) -> list[Record]:
    config = settings_of(job.case, job.config)
    runs: dict[str, MethodRun] = run_rivals(product, registrar, config, job.clouds)
    return [score(_labels(case, name, plan), run, truth) for name, run in runs.items()]


def _false_plans(job: Job, inputs: CaseInputs) -> Iterator[tuple[str, str, GridMap]]:
    """Yield names, groups and plans on which every accepted pose is wrong."""
    plain = plain_cases(job.suite_seed) if job.case.wrong_cases else ()
    for number in job.case.wrong_cases:
        yield plain[number].name, 'wrong_building', make_plan(plain[number])
    if job.case.has_mirrored_plan:
        yield f'{job.case.name} mirrored', 'mirrored_plan', inputs.plan.mirrored()
