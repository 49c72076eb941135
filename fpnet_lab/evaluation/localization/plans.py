# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plans of generated buildings for the robot, inexact in one named way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fpnet_core.geometry import Affine2D
from fpnet_lab.evaluation.localization.cases import Distortion
from fpnet_lab.sim.drawn.distort import DrawnPlan, laid_elsewhere, renovated, rough_drawing
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drawn.styles import CLEAN, STYLES
from fpnet_lab.sim.types import BuildingPlan

RESOLUTION_M = 0.05
UNKNOWN_SCALE = (0.67, 1.5)
"""Range of nominal over true metres for drawings of unknown scale. Chosen."""

# Chosen, not measured:
_STRETCH = {Distortion.STRETCHED_5: 0.05, Distortion.STRETCHED_10: 0.1}
_LEAST_STRETCH = 0.5  # least stretch of each axis, as a share of the named one
_SKETCH_STRETCH = 0.02

# Given: second elements of the seed, different from the recording's streams.
_DRAWING_STREAM, _ROUGH_STREAM = 11, 12


def draw_plan(plan: BuildingPlan, distortion: Distortion, seed: int) -> DrawnPlan:
    """
    Draw a building's plan at a random pose.

    Stretched plans are too large along one axis and too small along the other, each by half to all
    of the named share. Changed walls are added, displaced or left out. With unknown scale, the
    raster's resolution is off by up to half.
    """
    rng = np.random.default_rng((seed, _DRAWING_STREAM))
    stretch = Affine2D(np.diag(_axis_scales(distortion, rng)), np.zeros(2))
    style = STYLES['sketch'] if distortion is Distortion.SKETCH else CLEAN
    sheet = render_plan(plan, RESOLUTION_M, T_plan_building=stretch, style=style)
    if distortion is Distortion.CHANGED_WALLS:
        sheet = renovated(sheet, plan, stretch, rng)
    return laid_elsewhere(sheet, stretch, rng)


def draw_roughly(plan: BuildingPlan, distortion: Distortion, seed: int) -> DrawnPlan:
    """
    Draw a building's plan with rooms of wrong sizes, deformed walls and missing walls.

    Its ``A_plan_building`` is the best affine fit. Walls are up to a metre from their fitted
    position.
    """
    drawn = draw_plan(plan, distortion, seed)
    kind = tuple(Distortion).index(distortion)
    rough = rough_drawing(drawn.grid, np.random.default_rng((seed, _ROUGH_STREAM, kind)))
    return DrawnPlan(rough.grid, rough.fitted() @ drawn.A_plan_building)


def _axis_scales(distortion: Distortion, rng: np.random.Generator) -> Sequence[float]:
    """Return nominal over true metres along x and y."""
    if distortion is Distortion.UNKNOWN_SCALE:
        return (float(np.exp(rng.uniform(*np.log(UNKNOWN_SCALE)))),) * 2
    if distortion is Distortion.SKETCH:
        return tuple(1.0 + rng.uniform(-_SKETCH_STRETCH, _SKETCH_STRETCH, size=2))
    largest = _STRETCH.get(distortion, 0.0)
    sign = float(np.copysign(1.0, 0.5 - rng.random()))
    share = largest * rng.uniform(_LEAST_STRETCH, 1.0, size=2)
    return 1.0 + sign * float(share[0]), 1.0 - sign * float(share[1])
