# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Storeys of one generated site: equal ones, such as share most of their walls, and others."""

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
"""Given: share of its walls by which a storey differs from one that it is told apart from."""

_MOST_ROUNDS = 40  # numerical: of changes, until a storey differs by so much


class Likeness(StrEnum):
    """How a storey is like the one that the robot is on."""

    TRUE = 'true'
    EQUAL = 'equal'  # the same drawing
    ALIKE = 'alike'  # the same building with other inner walls
    OTHER = 'other'  # another building of the same family


@dataclass(frozen=True, eq=False)
class DrawnStorey:
    """A storey's drawing; ``different`` is the share of its walls that the true one has not."""

    name: str
    likeness: Likeness
    drawn: DrawnPlan
    different: float


def draw_storeys(
    plan: BuildingPlan, likenesses: tuple[Likeness, ...], rng: np.random.Generator
) -> tuple[DrawnStorey, ...]:
    """
    Draw the storeys of a site, each on a sheet of its own that lies anywhere, turned by any angle.

    Parameters
    ----------
    plan : the storey that the robot is on
    likenesses : of all storeys, from the lowest up
    rng : draws what differs and where the sheets lie
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
    """Return a storey with walls moved, taken down and put up until it differs enough."""
    changed = sheet
    for _ in range(_MOST_ROUNDS):
        changed = renovated(changed, plan, Affine2D.identity(), rng)
        if min(share_apart(changed, sheet), share_apart(sheet, changed)) >= DIFFERENT:
            break
    return changed


def share_apart(sheet: GridMap, other: GridMap) -> float:
    """Return the share of the walls of a sheet that are not near any of another's; same raster."""
    walls, there = (each.cells == OCCUPIED for each in (sheet, other))
    apart = cells_to_nearest(there) * sheet.resolution > APART_M
    return float((walls & apart).sum()) / max(int(walls.sum()), 1)
