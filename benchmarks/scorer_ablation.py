# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Ablation of the placement scorer's features on the same placements.

Run: python benchmarks/scorer_ablation.py --data ../shared/data --trials runs/scorer/trials
     [--cases 200] [--json OUT]; then fpnet bench figures scorer_ablation=OUT

Robot maps of the test split, clipped to each band, are matched with the correct and two other
buildings' plans. Scorers are fitted to trials of ``fpnet train scorer`` (development split) with a
placement's own features, plus those of competing hypotheses, plus the drawing's deformation.
"""

from pathlib import Path

import numpy as np

from fpnet_core.config import FpnetConfig
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.evaluation.robots.robot_pairs import BANDS
from fpnet_lab.kept import read_kept
from fpnet_lab.training import use_threads
from fpnet_lab.training.scorer import ScorerTraining, fit_scorer, stack_trials
from fpnet_lab.training.scorer_figures import at_prior, mean_log_probability
from fpnet_lab.training.scorer_trials import COLUMNS, Trials, TrialSource

SEED = 7000
BENT = ('bent', 'bend', 'contrast', 'best_score', 'second_score', 'mean_score')
JUDGES = {
    'features alone': (*BENT, 'rival'),
    'with rivals': BENT,
    'with deformation': (),
}


def measured(best, is_right, trials, threshold):
    """Return shares per band of right, accepted and wrongly accepted best placements."""
    kept, own = (np.array([getattr(t, name) for t in trials]) for name in ('kept', 'is_own'))
    claim = best >= threshold
    rows = {}
    for name, (low, high) in BANDS.items():
        here = (kept >= low) & (kept <= high)
        mine, others = here & own, here & ~own
        rows[f'{name} %'] = {
            'trials': int(mine.sum()),
            'right': round(float(is_right[mine].mean()), 3),
            'claimed_right': round(float((claim & is_right)[mine].mean()), 3),
            'claimed_wrong': round(float((claim & ~is_right)[mine].mean()), 4),
            'foreign_trials': int(others.sum()),
            'foreign_claimed': round(float(claim[others].mean()), 4),
        }
    return rows


def main() -> None:
    """Print shares per scorer and band."""
    parser = script_parser(__doc__)
    parser.add_argument('--data', type=Path, required=True)
    parser.add_argument('--trials', type=Path, required=True)
    parser.add_argument('--cases', type=int, default=200)
    arguments = parser.parse_args()
    use_threads(1)
    config = FpnetConfig()
    source = TrialSource(
        'real', SEED, arguments.data, config, LearnedMatcher(config.matcher), 'report'
    )
    trials = [t for index in range(arguments.cases) for t in source.trials(index)]
    files = sorted(arguments.trials.glob('*.npz'))
    learned = [trial for file in files for trial in read_kept(file, Trials, COLUMNS)]
    data, seen = stack_trials(learned), stack_trials(trials)
    claim = config.localizer.match_probability
    report = {}
    for name, without in JUDGES.items():
        networks = fit_scorer(data, ScorerTraining(without=without))
        log_p = mean_log_probability(networks, seen).double().numpy()
        p = at_prior(log_p, config.localizer.plan_prior)[:, :-2]
        index = p.argmax(axis=1)
        rows = np.arange(len(p))
        is_right = seen.right.numpy()[rows, index]
        report[name] = measured(p[rows, index], is_right, trials, claim)
    finish('scorer_ablation', arguments.json, {'judges': report})


if __name__ == '__main__':
    main()
