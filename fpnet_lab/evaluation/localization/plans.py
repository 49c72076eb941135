# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The plan that a robot is given of a generated building, inexact in one named way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.types import FREE, OCCUPIED, GridMap
from fpnet_lab.evaluation.localization.cases import Distortion
from fpnet_lab.sim.config import BuildingConfig
from fpnet_lab.sim.render import fill_polygons, render_plan
from fpnet_lab.sim.styles import CLEAN, STYLES
from fpnet_lab.sim.types import BuildingPlan
from fpnet_lab.sim.walls import draw_wall_changes

RESOLUTION_M = 0.05
UNKNOWN_SCALE = (0.67, 1.5)
"""Range of nominal over true metres where the scale of a drawing is unknown. Chosen."""

# Chosen, not measured:
_STRETCH = {Distortion.STRETCHED_5: 0.05, Distortion.STRETCHED_10: 0.1}
_LEAST_STRETCH = 0.5  # share of the named stretch that each axis has at least
_SKETCH_STRETCH = 0.02
_LARGEST_SHIFT_M = 20.0

_DRAWING_STREAM = 11  # given: second word of the seed, apart from the streams of the recording
# Chosen, not measured:
_ALL_WALLS = BuildingConfig(moved_walls=1.0, removed_walls=1.0, added_walls=1.0, glass=(0.0, 0.0))


@dataclass(frozen=True, eq=False)
class DrawnPlan:
    """A plan's raster; ``A_plan_building`` maps true metres to its nominal ones."""

    grid: GridMap
    A_plan_building: Affine2D


def draw_plan(plan: BuildingPlan, distortion: Distortion, seed: int) -> DrawnPlan:
    """
    Draw a building's plan, turned by any angle and laid anywhere.

    Stretched plans are too large along one axis and too small along the other, by at least half
    of the named share each. Changed walls are drawn where there are none, displaced or left out.
    An unknown scale means that the raster's resolution is off by up to half.
    """
    rng = np.random.default_rng((seed, _DRAWING_STREAM))
    stretch = Affine2D(np.diag(_axis_scales(distortion, rng)), np.zeros(2))
    style = STYLES['sketch'] if distortion is Distortion.SKETCH else CLEAN
    sheet = render_plan(plan, RESOLUTION_M, T_plan_building=stretch, style=style)
    if distortion is Distortion.CHANGED_WALLS:
        sheet = _with_changed_walls(sheet, plan, stretch, rng)
    x, y = rng.uniform(-_LARGEST_SHIFT_M, _LARGEST_SHIFT_M, size=2)
    T_plan_sheet = SE2.from_xy_yaw(x, y, float(rng.uniform(-np.pi, np.pi)))
    grid = GridMap(sheet.cells, sheet.resolution, T_plan_sheet @ sheet.T_frame_grid, sheet.frame)
    return DrawnPlan(grid, T_plan_sheet @ stretch)


def _axis_scales(distortion: Distortion, rng: np.random.Generator) -> Sequence[float]:
    """Nominal over true metres along x and y."""
    if distortion is Distortion.UNKNOWN_SCALE:
        return (float(np.exp(rng.uniform(*np.log(UNKNOWN_SCALE)))),) * 2
    if distortion is Distortion.SKETCH:
        return tuple(1.0 + rng.uniform(-_SKETCH_STRETCH, _SKETCH_STRETCH, size=2))
    largest = _STRETCH.get(distortion, 0.0)
    sign = 1.0 if rng.random() < 0.5 else -1.0
    share = largest * rng.uniform(_LEAST_STRETCH, 1.0, size=2)
    return 1.0 + sign * float(share[0]), 1.0 - sign * float(share[1])


def _with_changed_walls(
    sheet: GridMap, plan: BuildingPlan, A_plan_building: Affine2D, rng: np.random.Generator
) -> GridMap:
    """Take walls off the drawing, put others on it; the building stays as it is."""
    changes = draw_wall_changes(plan, rng, _ALL_WALLS)
    cells = sheet.cells.copy()
    for walls, value in ((changes.removed, FREE), (changes.added, OCCUPIED)):
        rings = [shapely.get_coordinates(wall.exterior)[:-1] for wall in walls]
        rings_px = [sheet.xy_to_rc(A_plan_building.apply(r))[:, ::-1] + 0.5 for r in rings]
        fill_polygons(cells, rings_px, value, keep_thin=True)
    return GridMap(cells, sheet.resolution, sheet.T_frame_grid, sheet.frame)
