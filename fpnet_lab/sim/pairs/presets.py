# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Named configurations of pair sets, including those of the paper (section V-A2)."""

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
PAPER_PAIRS_PER_PLAN = 50  # given: the paper's synthetic protocol

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
"""Real storeys of the test split: used for reported results, never for choosing parameters."""

Split = Literal['tune', 'report']
SPLITS: dict[Split, tuple[str, ...]] = {'tune': TUNE_FLOORS, 'report': REPORT_FLOORS}


@dataclass(frozen=True)
class Preset:
    """
    A configuration of a pair set.

    ``plans`` is the number of generated storeys if no floorplans are given; None if the caller
    sets the number of pairs. ``needs_plans`` requires given floorplans.
    """

    config: SimConfig
    plans: int | None = None
    needs_plans: bool = False

    def pair_count(self, given_plans: int) -> int | None:
        """Return the number of pairs for ``given_plans`` given plans, 0 for generated ones."""
        if self.plans is None:
            return None
        return (given_plans or self.plans) * self.config.pairs_per_plan


# Point-symmetric storeys have no unique correct pose. They are used only in tests that check that
# the localizer does not accept a pose there.
_DECIDABLE = tuple(family for family in BUILDINGS if family != 'turned')

# Anisotropic scale of at most 1 %, because the paper estimates a similarity. Chosen.
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
``default``: generated storeys and ray-cast robot tours, the training data of fpnet.
``paper-synthetic``: 500 generated storeys x 50 partial maps with noise and clips.
``paper-real``: the same sampler with given floorplans, 50 robot maps each. ``paper-challenging``:
generated or given drawings, clipped to small areas. Chosen.
"""


def preset(name: str) -> Preset:
    """Return a preset by name; raise ConfigError if there is none."""
    if name not in PRESETS:
        raise ConfigError(f'no preset {name!r}; expected one of {", ".join(PRESETS)}')
    return PRESETS[name]


def in_split(plans: Sequence[tuple[str, GridMap]], split: str) -> list[tuple[str, GridMap]]:
    """
    Return the plans in one split: ``tune`` (development split) or ``report`` (test split).

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
