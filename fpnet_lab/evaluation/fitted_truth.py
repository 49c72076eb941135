# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ground truth of the real laser logs: their fitted placement on the floorplans."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fpnet.recordings.truth import read_json
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import read_map
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.types import GridMap

_REMEDY = 'give the folder radish of the shared data'


@dataclass(frozen=True, eq=False)
class FittedTruth:
    """
    Placement of a laser log on its floorplan.

    ``plan`` is the drawing for the localizer: flipped if the stored drawing is a mirror image of
    the building. ``A_plan_log`` maps log metres to nominal plan metres; it is a fit, not a survey.
    """

    log: Path
    plan: GridMap
    A_plan_log: Affine2D


def read_fitted_truth(folder: Path, name: str) -> FittedTruth:
    """
    Read the fit of log ``name`` (``intel``, ``freiburg-079``) from a ``radish`` data folder.

    Raises
    ------
    FpnetError
        If the folder has no such log or no pair for it.
    """
    index = read_json(folder / 'maps_index.json', _REMEDY)
    pairs = read_json(folder / 'pairs.json', _REMEDY)['pairs']
    pairs = [pair for pair in pairs if pair['id'].startswith(f'{name}_full')]
    if name not in index or not pairs:
        raise FpnetError(f'{folder}: no fitted pair for the log {name!r}')
    pair, raster = pairs[0], index[name]
    plan = read_map(folder / pair['floorplan'])
    A_image_log = Affine2D.from_matrix(pair['affine_2x3']) @ _pixel_from_world(
        raster, pair['robot_map_was_mirrored_vs_source']
    )
    A_plan_log = pixel_to_xy(plan) @ A_image_log
    if A_plan_log.is_mirrored:
        width_m = plan.shape[1] * plan.resolution
        flip = Affine2D(np.diag([-1.0, 1.0]), np.array([width_m, 0.0]))
        A_plan_log = plan.T_frame_grid @ flip @ plan.T_frame_grid.inv() @ A_plan_log
        plan = plan.mirrored()
    log = folder / 'logs' / f'{name}-corrected.log.gz'
    return FittedTruth(log, plan, A_plan_log)


def _pixel_from_world(raster: dict[str, Any], flipped: bool) -> Affine2D:
    """Return the map from world metres to pixels of the stored robot map (x right, y down)."""
    resolution = raster['resolution_m_per_px']
    width, height = raster['size_px']
    x0, y0 = raster['world_min_xy']
    upright = Affine2D(
        np.diag([1.0, -1.0]) / resolution,
        np.array([-x0 / resolution - 0.5, height - 0.5 + y0 / resolution]),
    )
    if not flipped:
        return upright
    flip = Affine2D(np.diag([-1.0, 1.0]), np.array([width - 1.0, 0.0]))
    return Affine2D.from_matrix((flip @ upright).matrix)
