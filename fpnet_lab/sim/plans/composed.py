# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Layout families composed of finished parts: symmetric buildings and disconnected wings."""

from __future__ import annotations

import numpy as np

from fpnet_core.geometry import Affine2D
from fpnet_lab.sim.plans.families import (
    bank_depth,
    branched,
    corridor_width,
    double_corridor,
    racetrack,
)
from fpnet_lab.sim.plans.finish import finish
from fpnet_lab.sim.plans.layout import Style
from fpnet_lab.sim.plans.skeleton import Arm, build_cells
from fpnet_lab.sim.types import BuildingPlan, PlanDoor


def mirrored(rng: np.random.Generator, style: Style) -> BuildingPlan:
    """Return two wings that are mirror images, joined where their corridor crosses the axis."""
    half, width = _half(rng, style)
    return _join_halves(half, Affine2D(np.diag([-1.0, 1.0]), np.zeros(2)), width, 'mirrored')


def turned(rng: np.random.Generator, style: Style) -> BuildingPlan:
    """Return a wing and its copy rotated by 180 degrees: the plan is point-symmetric."""
    half, width = _half(rng, style)
    return _join_halves(half, Affine2D(-np.eye(2), np.zeros(2)), width, 'turned')


def disconnected(rng: np.random.Generator, style: Style) -> BuildingPlan:
    """Return two adjacent parts of a building without a connecting door on this storey."""
    parts = []
    for _ in range(2):
        layout = (double_corridor, branched, racetrack)[int(rng.integers(3))]
        parts.append(finish(rng, layout(rng, style), style, 'disconnected'))
    first, second = (part.extent for part in parts)
    gap = rng.uniform(2.0 * style.wall_m, 8.0)
    shift = np.array([first[1, 0] + gap - second[0, 0], rng.uniform(-8.0, 8.0)])
    moved = parts[1].mapped(Affine2D(np.eye(2), shift), len(parts[0].rooms))
    return BuildingPlan(
        parts[0].rooms + moved.rooms, parts[0].doors + moved.doors, style.wall_m, 'disconnected'
    )


def _half(rng: np.random.Generator, style: Style) -> tuple[BuildingPlan, float]:
    """Return a wing with a corridor from the origin along +x, and the corridor's width [m]."""
    width, depth = corridor_width(rng), bank_depth(rng, style)
    length = float(max(rng.uniform(14.0, 30.0), depth + width))
    arms = [Arm((0.0, 0.0), (length, 0.0), width, depth, bank_depth(rng, style))]
    if rng.random() < 0.6:
        nearest = depth + width / 2.0  # the side wing's rooms must not cross the axis
        x = float(max(rng.uniform(0.6, 1.0) * length - width / 2.0, nearest))
        reach = rng.uniform(10.0, 20.0)
        side = 1.0 if rng.random() < 0.5 else -1.0
        arms.append(
            Arm(
                (x, 0.0), (x, side * reach), width, depth, depth, before_m=width / 2.0, cap_m=depth
            )
        )
    return finish(rng, build_cells(rng, arms, style), style, ''), width


def _join_halves(half: BuildingPlan, A: Affine2D, width_m: float, family: str) -> BuildingPlan:
    """Join a wing and its image under ``A`` by an opening across the corridor at the origin."""
    image = half.mapped(A, len(half.rooms))
    corridor = next(i for i, room in enumerate(half.rooms) if room.kind == 'corridor')
    side = width_m / 2.0 - half.wall_m / 2.0
    seam = PlanDoor(
        (corridor, corridor + len(half.rooms)), np.array([[0.0, -side], [0.0, side]]), is_open=True
    )
    return BuildingPlan(
        half.rooms + image.rooms, (*half.doors, *image.doors, seam), half.wall_m, family
    )
