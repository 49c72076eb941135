# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings of generated storeys in all styles, at their true scale."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fpnet_core.geometry import Affine2D
from fpnet_core.types import GridMap
from fpnet_lab.sim.config import DrawingConfig
from fpnet_lab.sim.drawn.drawings import draw_placement
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.styles import StyleConfig, draw_style
from fpnet_lab.sim.plans.sources import GeneratedPlans
from fpnet_lab.sim.types import BuildingPlan

CELL_M = (0.025, 0.12)
"""Smallest and largest cell edges of drawings; sampled log-uniformly. Chosen."""

# Chosen to span real drawings, with more detailed ones than in the matcher's input:
STOREYS = GeneratedPlans(6, 64)
HOMES = GeneratedPlans(3, 20, ('home',))
PRACTICES = GeneratedPlans(3, 30, ('practice',))
HOUSES = GeneratedPlans(3, 64, ('house',))
_WALL_FACTOR = (0.5, 1.8)  # ratio of drawn to true thickness
_PLACEMENT = DrawingConfig(scale_error=0.0, axis_error=0.02)
_STYLES = StyleConfig(
    thin_walls=0.2, thick_walls=0.15, double_walls=0.12, door_leaves=0.2, door_arcs=0.2,
    furniture=0.35, text=0.2, dimensions=0.08, white_paper=0.3, windows=0.3,
)  # fmt: skip


def draw_cell_m(rng: np.random.Generator) -> float:
    """Sample the cell edge of a drawing [m]."""
    return float(np.exp(rng.uniform(*np.log(CELL_M))))


def styled_drawing(rng: np.random.Generator, source: GeneratedPlans = STOREYS) -> GridMap:
    """Return the drawing of a new generated storey in a random style, at its true scale."""
    return draw_styled(rng, source=source)[2]


def draw_styled(
    rng: np.random.Generator,
    changed: Callable[[BuildingPlan, np.random.Generator], BuildingPlan] = lambda plan, _: plan,
    source: GeneratedPlans = STOREYS,
) -> tuple[BuildingPlan, Affine2D, GridMap]:
    """
    Return a new storey, ``A_plan_building``, and the drawing of :func:`styled_drawing`.

    ``changed`` is applied to the storey before it is drawn.
    """
    plan = source.storey(int(rng.integers(2**31)), 0, 0).plan
    plan = changed(plan, rng)
    resolution_m = draw_cell_m(rng)
    wall_m = plan.wall_m * float(rng.uniform(*_WALL_FACTOR))
    A_plan_building = draw_placement(rng, _PLACEMENT)
    grid = render_plan(
        plan,
        resolution_m=resolution_m,
        wall_m=wall_m,
        T_plan_building=A_plan_building,
        style=draw_style(rng, _STYLES),
    )
    return plan, A_plan_building, grid
