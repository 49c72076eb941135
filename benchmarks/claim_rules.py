# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
How often must a look confirm a claim? Rules over the looks of drives, on right and wrong plans.

Run: python benchmarks/claim_rules.py [--drives 42] [--seed 5000] [--trials runs/judge/trials]
     [--json OUT]; then fpnet bench figures claim_rules=OUT

A look comes each time a tenth more of the building has been seen. A rule asks for so many looks in
a row whose best placement has at least some probability; what it claims first is right or wrong,
and on another building's plan always wrong. ``--trials`` keeps the looks of drives, and reads
those that ``fpnet train-judge`` has gathered (seed 0).
"""

from itertools import product
from pathlib import Path
import tempfile

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.judging import Judge
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.training.judge_gathering import TrialAmounts, gather_trials, trial_blocks

LOOKS = (1, 2, 3)
PROBABILITIES = (0.9, 0.95, 0.97, 0.98, 0.99)


def plans_of(trials):
    """Group the looks of one drive by plan: its own, and each other building's."""
    own = [trial for trial in trials if trial.is_own]
    foreign = [trial for trial in trials if not trial.is_own]
    others = round(len(foreign) / max(len(own), 1))
    return own, [foreign[number::others] for number in range(others)]


def first_claim(looks, needed, probability):
    """Return the number of the look that claims and whether it is right; None without a claim."""
    in_row = 0
    for number, (p, is_right) in enumerate(looks):
        in_row = in_row + 1 if p >= probability else 0
        if in_row == needed:
            return number, is_right
    return None


def outcome(judged, needed, probability):
    """Return what a rule comes to over the looks of all drives."""
    own = [first_claim(plans[0], needed, probability) for plans in judged]
    foreign = [first_claim(p, needed, probability) for plans in judged for p in plans[1:]]
    made = [claim for claim in own if claim is not None]
    return {
        'looks': needed,
        'probability': probability,
        'first_look': float(np.median([claim[0] + 1 for claim in made])) if made else None,
        'own': len(own),
        'never': len(own) - len(made),
        'wrong': sum(not is_right for _, is_right in made),
        'foreign': len(foreign),
        'foreign_claims': sum(claim is not None for claim in foreign),
    }


def main() -> None:
    """Print one row per rule."""
    parser = script_parser(__doc__)
    parser.add_argument('--drives', type=int, default=42)
    parser.add_argument('--seed', type=int, default=5000)
    parser.add_argument('--trials', type=Path)
    arguments = parser.parse_args()
    config = FpnetConfig()
    judge = Judge.configured(config.localizer)
    amounts = TrialAmounts(real=0, drawn=0, foreign=0, generated=0, drives=arguments.drives)
    with tempfile.TemporaryDirectory() as folder:
        path = arguments.trials or Path(folder)
        trials = gather_trials(path, trial_blocks(arguments.seed, None, config, amounts), 2)
    drives = {trial.building: [] for trial in trials}
    for trial in trials:
        drives[trial.building].append(trial)
    judged = [
        [[judge.best_of(t.evidence, t.right) for t in looks] for looks in (own, *foreign)]
        for own, foreign in map(plans_of, drives.values())
    ]
    rules = [outcome(judged, *rule) for rule in product(LOOKS, PROBABILITIES)]
    finish('claim_rules', arguments.json, {'drives': len(judged), 'rules': rules})


if __name__ == '__main__':
    main()
