# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Comparison of confirmation rules for the first acceptance, on correct and wrong plans.

Run: python benchmarks/claim_rules.py [--drives 42] [--seed 5000] [--workers 2] [--json OUT]
     then fpnet bench figures claim_rules=OUT

The first 25 s of recordings as in ``fpnet bench localization`` with another seed, with KISS-ICP,
on the correct plan and on three other buildings' plans. The localizer updates every second but
never accepts, and each update also tests the plan's mirror image. A rule requires a number of
consecutive updates with a minimum probability of the best placement, each with a minimum of
additional observed floor area. The first acceptance is right or wrong; on another building's plan
it is always wrong.
"""

from collections.abc import Iterator
from dataclasses import dataclass
import functools
from itertools import takewhile
from pathlib import Path

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.io.scans import Scan
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import lengths_along
from fpnet_core.types import GridMap
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.evaluation.localization.cases import Case, plain_cases
from fpnet_lab.evaluation.localization.drives import ProductRun, registered, run_product
from fpnet_lab.evaluation.localization.inputs import make_inputs, make_plan
from fpnet_lab.evaluation.localization.records import RIGHT, Truth, belief_errors
from fpnet_lab.evaluation.localization.runs import settings_of
from fpnet_lab.pool import each_done

FIRST_S, TICK_S = 25.0, 1.0
WRONG_PLANS = 3
NEVER = 1_000_000  # updates: nothing is confirmed, so every update searches globally
SURE, NEWS_M2 = 0.99, 5.0
RULES = (
    *((1, sure, 0.0) for sure in (0.9, 0.95, SURE)),
    *((2, sure, NEWS_M2) for sure in (0.9, 0.95)),
    *((2, SURE, news_m2) for news_m2 in (0.0, 2.0, NEWS_M2, 10.0, 20.0)),
    (3, SURE, NEWS_M2),
)
"""Number of updates, probability and additional floor area [m^2]."""


@dataclass(frozen=True)
class FirstLook:
    """An update: probability and correctness of the best placement; floor area and path so far."""

    probability: float
    is_right: bool
    floor_m2: float
    path_m: float


def never_claiming(config: FpnetConfig) -> FpnetConfig:
    """Return a configuration in which every update searches globally, including mirror images."""
    update = {'confirm_updates': NEVER, 'mirror_check_updates': 1}
    return config.model_copy(update={'localizer': config.localizer.model_copy(update=update)})


def first_scans(case: Case, config: FpnetConfig) -> tuple[list[Scan], GridMap, Truth]:
    """Return the first scans with poses, the correct plan, and the ground truth."""
    inputs = make_inputs(case, Path())
    scans = iter(inputs.scans)
    first = next(scans)
    until_ns = first.stamp_ns + FIRST_S * NS_PER_S
    early = [first, *takewhile(lambda scan: scan.stamp_ns <= until_ns, scans)]
    truth = Truth(inputs.truth, inputs.A_plan_truth)
    return list(registered(early, config.odometry)), inputs.plan, truth


def looks_of(case: Case, cases: tuple[Case, ...], config: FpnetConfig) -> list[list[FirstLook]]:
    """Return the updates on the correct plan, followed by those on each other plan."""
    config = never_claiming(settings_of(case, config))
    scans, own, truth = first_scans(case, config)
    found = [list(_updates(run_product(scans, own, config, TICK_S), truth))]
    for number in case.wrong_cases[:WRONG_PLANS]:
        found.append(list(_updates(run_product(scans, make_plan(cases[number]), config, TICK_S))))
    return found


def _updates(product: ProductRun, truth: Truth | None = None) -> Iterator[FirstLook]:
    run = product.run
    errors = belief_errors(run, truth) if truth else [None] * len(run.beliefs)
    path_m = lengths_along(run.odometry.xy)
    for output, error in zip(product.replay.outputs, errors, strict=True):
        if output.submap is None:
            continue
        is_right = error is not None and error[0] <= RIGHT[0] and error[1] <= RIGHT[1]
        here = np.searchsorted(run.odometry.stamps_ns, output.stamp_ns)
        yield FirstLook(
            output.probability if output.estimates else 0.0,
            is_right,
            output.submap.free_area_m2,
            float(path_m[min(here, len(path_m) - 1)]),
        )


def first_claim(
    looks: list[FirstLook], needed: int, probability: float, news_m2: float
) -> FirstLook | None:
    """Return the update at which the rule accepts, or None."""
    in_row, counted_m2 = 0, 0.0
    for look in looks:
        if look.probability < probability:
            in_row = 0
        elif not in_row or look.floor_m2 >= counted_m2 + news_m2:
            in_row, counted_m2 = in_row + 1, look.floor_m2
        if in_row == needed:
            return look
    return None


def outcome(drives: list[list[list[FirstLook]]], rule: tuple[int, float, float]) -> dict:
    """Return the results of a rule over all recordings."""
    own = [first_claim(plans[0], *rule) for plans in drives]
    foreign = [first_claim(looks, *rule) for plans in drives for looks in plans[1:]]
    made = [claim for claim in own if claim is not None]
    return {
        **dict(zip(('looks', 'probability', 'news_m2'), rule, strict=True)),
        'first_m': float(np.median([claim.path_m for claim in made])) if made else None,
        'own': len(own),
        'never': len(own) - len(made),
        'wrong': sum(not claim.is_right for claim in made),
        'foreign': len(foreign),
        'foreign_claims': sum(claim is not None for claim in foreign),
    }


def main() -> None:
    """Print one row per rule."""
    parser = script_parser(__doc__)
    parser.add_argument('--drives', type=int, default=42)
    parser.add_argument('--seed', type=int, default=5000)
    parser.add_argument('--workers', type=int, default=2)
    arguments = parser.parse_args()
    cases = plain_cases(arguments.seed)
    make = functools.partial(looks_of, cases=cases, config=FpnetConfig())
    drives = []
    for case, looks in each_done(make, cases[: arguments.drives], arguments.workers):
        print(f'{case.name}: {len(looks[0])} updates', flush=True)
        drives.append(looks)
    rules = [outcome(drives, rule) for rule in RULES]
    finish('claim_rules', arguments.json, {'drives': len(drives), 'rules': rules})


if __name__ == '__main__':
    main()
