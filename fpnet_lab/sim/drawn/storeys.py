# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Storeys of a generated site: identical ones, similar ones, and other buildings."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from fpnet_core.differences.finding import APART_M
from fpnet_core.geometry import Affine2D
from fpnet_core.raster.distance import cells_to_nearest
from fpnet_core.types import OCCUPIED, GridMap
from fpnet_lab.sim.drawn.distort import DrawnPlan, laid_elsewhere, renovated
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.types import BuildingPlan

CELL_M = 0.05
DIFFERENT = 0.1
"""Given: minimum share of differing walls of distinguishable storeys."""

_MOST_ROUNDS = 40  # numerical: maximum number of rounds of changes


class Likeness(StrEnum):
    """Similarity of a storey to the robot's storey."""

    TRUE = 'true'
    EQUAL = 'equal'  # the same drawing
    ALIKE = 'alike'  # the same building with other inner walls
    OTHER = 'other'  # another building of the same family


@dataclass(frozen=True, eq=False)
class DrawnStorey:
    """A storey's drawing; ``different`` is the share of its walls missing in the true storey."""

    name: str
    likeness: Likeness
    drawn: DrawnPlan
    different: float


def draw_storeys(
    plan: BuildingPlan, likenesses: tuple[Likeness, ...], rng: np.random.Generator
) -> tuple[DrawnStorey, ...]:
    """
    Draw the storeys of a site, each on a sheet with random origin and rotation.

    Parameters
    ----------
    plan : the robot's storey
    likenesses : similarity of each storey, from the lowest up
    rng : random generator of the differences and the sheets' poses
    """
    identity = Affine2D.identity()
    true = render_plan(plan, CELL_M)
    storeys = []
    for number, likeness in enumerate(likenesses):
        if likeness is Likeness.ALIKE:
            sheet = changed_sheet(true, plan, rng)
        elif likeness is Likeness.OTHER:
            sheet = render_plan(generate_plan(rng, plan.family), CELL_M)
        else:
            sheet = true
        different = 1.0 if likeness is Likeness.OTHER else share_apart(sheet, true)
        drawn = laid_elsewhere(sheet, identity, rng)
        storeys.append(DrawnStorey(f'L{number}', likeness, drawn, different))
    return tuple(storeys)


def changed_sheet(sheet: GridMap, plan: BuildingPlan, rng: np.random.Generator) -> GridMap:
    """Return a storey with walls moved, removed and added until it differs enough."""
    changed = sheet
    for _ in range(_MOST_ROUNDS):
        changed = renovated(changed, plan, Affine2D.identity(), rng)
        if min(share_apart(changed, sheet), share_apart(sheet, changed)) >= DIFFERENT:
            break
    return changed


def share_apart(sheet: GridMap, other: GridMap) -> float:
    """Return the share of a sheet's wall cells without a nearby wall in ``other``; same raster."""
    walls, there = (each.cells == OCCUPIED for each in (sheet, other))
    apart = cells_to_nearest(there) * sheet.resolution > APART_M
    return float((walls & apart).sum()) / max(int(walls.sum()), 1)
