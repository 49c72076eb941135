# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Errors of the scales stated in drawings, and benefit and cost of a wide scale prior.

Run: python benchmarks/stated_scales.py ../shared/data [--rounds 4] [--seed 1] [--json OUT]

Data: development split. First, a Gaussian and a Cauchy distribution are fitted to the errors of
stated scales; ``fpnet_core.localizer.scale`` uses the result for its wide scale prior. Then parts
of robot maps are matched with the correct plan and another building's, with a stated scale that is
right (within about 2 %) or 10 to 25 % wrong, and accepted as by ``fpnet match``.
"""

from collections import Counter
from dataclasses import replace
import json
from pathlib import Path

import numpy as np
from scipy import optimize, stats

from fpnet_core.config import FpnetConfig
from fpnet_core.geometry import Affine2D
from fpnet_core.localizer.global_localizer import GlobalLocalizer
from fpnet_core.localizer.maps import scaled_pair, segment_plan, segment_robot_map
from fpnet_core.localizer.prepared_maps import StageTimer
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.scoring import PlacementScorer
from fpnet_core.segmentation.moved import rescaled
from fpnet_core.submaps import submap_from_grid
from fpnet_lab.cli.reports import finish, script_parser
from fpnet_lab.evaluation.robots.robot_pairs import (
    BANDS,
    foreign_drawings,
    read_drawings,
    read_robot_pairs,
    varied,
)
from fpnet_lab.metrics import placement_error
from fpnet_lab.training import use_threads

SCATTER, WRONG = 0.02, (0.1, 0.23)  # logarithms


def stated_errors(pairs):
    """Return the log scale error and the log anisotropy of each drawing."""
    of = {pair.building: [] for pair in pairs}
    for pair in pairs:
        of[pair.building].append(np.linalg.svd(pair.A_plan_robot.linear, compute_uv=False))
    stretch = np.log([np.median(each, axis=0) for each in of.values()])
    return stretch.mean(axis=1), stretch[:, 0] - stretch[:, 1]


def fits(errors):
    """Return width and log likelihood of each zero-centred distribution."""
    found = {}
    for name, family in {'Gaussian': stats.norm, 'Cauchy': stats.cauchy}.items():

        def surprise(log_width, family=family):
            return -family.logpdf(errors, scale=np.exp(log_width)).sum()

        best = optimize.minimize_scalar(surprise, bounds=(-8.0, 0.0), method='bounded')
        found[name] = {'width': float(np.exp(best.x)), 'log_likelihood': float(-best.fun)}
    return found


def stating(pair, error):
    """Return the pair with a stated scale that is off by the log error ``error``."""
    factor = pair.A_plan_robot.scale * float(np.exp(-error))
    A = pair.A_plan_robot @ Affine2D(np.eye(2) / factor, np.zeros(2))
    return replace(pair, robot=rescaled(pair.robot, factor), A_plan_robot=A, is_metric=True)


class Bench:
    """Matching of maps and plans with and without a wide scale prior."""

    def __init__(self, data):
        self.pairs = read_robot_pairs(data, 'tune')
        self.drawings = read_drawings(data, 'tune', self.pairs)
        self._config = FpnetConfig()
        scorer = PlacementScorer.configured(self._config.localizer)
        self._global_localizer = GlobalLocalizer(
            LearnedMatcher(self._config.matcher), scorer, self._config
        )
        self._limit = self._config.localizer.match_probability
        self._plans = {}

    def cases(self, rounds, seed):
        """Yield the log scale error, the clipped pair and another building's plan."""
        for number in range(rounds):
            for index, pair in enumerate(self.pairs):
                for band, share in enumerate(BANDS.values()):
                    rng = np.random.default_rng([seed, number, index, band])
                    for error in (
                        rng.normal(0.0, SCATTER),
                        rng.choice([-1.0, 1.0]) * rng.uniform(*WRONG),
                    ):
                        cut = varied(stating(pair, float(error)), rng, share)
                        (other,) = foreign_drawings(pair.drawing, self.drawings, rng, 1)
                        yield float(error), cut, other

    def count(self, pair, other):
        """Return the counts of one case, for ``doubting`` (wide prior) and ``trusting``."""
        robot = segment_robot_map(submap_from_grid(pair.robot), self._config, is_metric=True)
        counts = Counter()
        for drawing in (pair.drawing, other):
            sides = scaled_pair(self._plan(drawing), robot, self._config)
            for name in ('trusting', 'doubting'):
                search = sides.search if name == 'doubting' else sides.search.as_stated
                asked = replace(sides, search=search)
                placed = self._global_localizer.find(asked, StageTimer(), self._limit).estimates
                is_accepted = len(placed) > 0 and placed.probability[0] >= self._limit
                if drawing is other:
                    counts[name, 'foreign claimed'] += is_accepted
                elif len(placed):
                    is_right = self._is_right(placed[0].A_plan_submap, pair, sides)
                    counts[name, 'right'] += is_right
                    counts[name, 'claimed right'] += is_accepted and is_right
                    counts[name, 'claimed wrong'] += is_accepted and not is_right
        return counts

    def _plan(self, drawing):
        if drawing.building not in self._plans:
            self._plans[drawing.building] = segment_plan(
                drawing.grid, self._config, is_metric=True
            )
        return self._plans[drawing.building]

    @staticmethod
    def _is_right(A, pair, sides):
        grid, plan = sides.sub.segmentation.grid, pair.plan
        x, y = grid.rc_to_xy(np.argwhere(grid.cells == 0).mean(axis=0)).tolist()
        error = placement_error(A, pair.A_plan_robot, (x, y))
        return error.is_right(float(np.hypot(*plan.shape)) * plan.resolution)


def main() -> None:
    """Print the fits, and a row per stated scale and scale prior."""
    parser = script_parser(__doc__)
    parser.add_argument('data', type=Path, help='the shared data')
    parser.add_argument('--rounds', type=int, default=4)
    parser.add_argument('--seed', type=int, default=1)
    arguments = parser.parse_args()
    use_threads(1)
    bench = Bench(arguments.data)
    errors = dict(zip(('scale', 'x against y'), stated_errors(bench.pairs), strict=True))
    report = {name: {'errors': e.round(3).tolist(), **fits(e)} for name, e in errors.items()}
    for name, fitted in report.items():
        print(name, json.dumps(fitted), flush=True)
    counts, cases = {'right': Counter(), 'wrong': Counter()}, Counter()
    for error, pair, other in bench.cases(arguments.rounds, arguments.seed):
        stated = 'wrong' if abs(error) >= WRONG[0] else 'right'
        counts[stated] += bench.count(pair, other)
        cases[stated] += 1
    for stated, counted in counts.items():
        for name in ('trusting', 'doubting'):
            row = {what: int(n) for (who, what), n in sorted(counted.items()) if who == name}
            report[f'stated {stated}, {name}'] = {'cases': cases[stated], **row}
    finish('stated_scales', arguments.json, report)


if __name__ == '__main__':
    main()
