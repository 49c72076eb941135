# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Named kinds of pair sets, among them those of the paper (section V-A2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from fpnet_core.errors import ConfigError
from fpnet_core.types import GridMap
from fpnet_lab.sim.config import DrawingConfig, SimConfig
from fpnet_lab.sim.plans import BUILDINGS
from fpnet_lab.sim.population.floors import TUNE_FLOORS

PAPER_PLANS = 500  # given: the paper's synthetic protocol
PAPER_PAIRS_PER_PLAN = 50  # given: the paper's

REPORT_FLOORS = (
    'lab_b_scan',
    'lab_d_scan',
    'lab_f_scan',
    'lab_intel',
    'Freiburg79_scan',
    'Freiburg101_scan',
    'office_f',
    'office_g',
    'office_h',
    'office_i',
)
"""The real storeys that figures are reported on; nothing is chosen by them."""

Split = Literal['tune', 'report']
SPLITS: dict[Split, tuple[str, ...]] = {'tune': TUNE_FLOORS, 'report': REPORT_FLOORS}


@dataclass(frozen=True)
class Preset:
    """
    A kind of pair set.

    ``plans`` is how many storeys the generator makes where no floorplans are given, None where
    the caller says how many pairs; ``needs_plans`` refuses generated storeys.
    """

    config: SimConfig
    plans: int | None = None
    needs_plans: bool = False

    def pair_count(self, given_plans: int) -> int | None:
        """Return the preset's number of pairs for so many given plans, 0 for generated ones."""
        if self.plans is None:
            return None
        return (given_plans or self.plans) * self.config.pairs_per_plan


# A storey that is its own image when turned has no single right answer: such storeys are for the
# localizer's tests, which must not claim a pose there.
_DECIDABLE = tuple(family for family in BUILDINGS if family != 'turned')

# Drawings to scale but for 1 %, because the paper's estimate is a similarity. Chosen.
_PAPER_DRAWING = DrawingConfig(axis_error=0.01)

# Chosen, not measured:
_PAPER = SimConfig(
    pairs_per_plan=PAPER_PAIRS_PER_PLAN,
    pairs_per_drawing=10,
    robot_map='clip',
    families=_DECIDABLE,
    drawing=_PAPER_DRAWING,
)

PRESETS: dict[str, Preset] = {
    'default': Preset(SimConfig()),
    'paper-synthetic': Preset(_PAPER, PAPER_PLANS),
    'paper-real': Preset(_PAPER, PAPER_PLANS, needs_plans=True),
    'paper-challenging': Preset(
        _PAPER.model_copy(update={'drawing': _PAPER_DRAWING.model_copy(update={'cut': 1.0})}),
        PAPER_PLANS,
    ),
}
"""
``default``: generated storeys and ray-cast tours of robots, which fpnet is trained on.
``paper-synthetic``: 500 generated storeys x 50 parts of their maps with noise and clips.
``paper-real``: the same sampler over given floorplans, 50 robot maps each. ``paper-challenging``:
drawings, generated or given, are cut into small areas. Chosen.
"""


def preset(name: str) -> Preset:
    """Return a preset by name; raises ConfigError where there is none."""
    if name not in PRESETS:
        raise ConfigError(f'no preset {name!r}; expected one of {", ".join(PRESETS)}')
    return PRESETS[name]


def in_split(plans: Sequence[tuple[str, GridMap]], split: str) -> list[tuple[str, GridMap]]:
    """
    Return the plans of one half of the labelled real storeys: ``tune`` or ``report``.

    Raises
    ------
    ConfigError
        If the split is unknown or none of the plans belongs to it.
    """
    names = {str(key): value for key, value in SPLITS.items()}.get(split)
    if names is None:
        raise ConfigError(f'no split {split!r}; expected one of {", ".join(SPLITS)}')
    chosen = [(name, grid) for name, grid in plans if name in names]
    if not chosen:
        raise ConfigError(
            f'none of the {len(plans)} plans is a {split} storey: {", ".join(names)}'
        )
    return chosen
