# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Files of an alignment: result, maps in both frames, corrected plan, Open-RMF building."""

from __future__ import annotations

from dataclasses import replace
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
import yaml

from fpnet.alignment.aligning import Alignment
from fpnet.alignment.corrected import CorrectedPlan, corrected_model, corrected_plan
from fpnet.exports.lines import write_dxf
from fpnet.exports.rmf import RmfLayer, RmfPicture, write_rmf
from fpnet.geojson import write_geojson
from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import write_map
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.raster.warping import warped_grid

RESULT, PICTURE = 'alignment.json', 'align.png'
"""Names of the result and of its picture in the output folder. Given."""

_LAYER = 'robot_map'
_HALF_PIXEL = Affine2D(np.eye(2), np.full(2, 0.5))
"""Physical: from pixels with integers at centres to those counted from the image's corner."""


def write_files(aligned: Alignment, folder: Path) -> list[str]:
    """
    Write all files of an alignment except its picture; return their names.

    Maps are map_server YAMLs with images. ``plan`` and ``robot_map_in_plan`` are in the drawing's
    frame, ``robot_map``, ``corrected_plan`` and its confidence in the robot map's.

    Raises
    ------
    ConfigError
        If ezdxf is not installed; all files but the DXF are written then.
    """
    folder.mkdir(parents=True, exist_ok=True)
    result = json.dumps(aligned.as_json(), indent=2, allow_nan=False)
    (folder / RESULT).write_text(result + '\n', encoding='utf-8')
    A = aligned.A_plan_map
    corrected = corrected_plan(aligned)
    maps = {
        'plan': aligned.plan.grid,
        'robot_map': aligned.robot,
        'robot_map_in_plan': replace(warped_grid(aligned.robot, A), frame='plan'),
        'corrected_plan': corrected.grid,
    }
    for name, grid in maps.items():
        write_map(grid, folder / f'{name}.yaml')
    write_confidence(corrected, folder / 'corrected_plan_confidence.yaml')
    write_geojson(folder / 'differences.geojson', aligned.differences)
    name = Path(aligned.plan.drawing.name).stem
    write_rmf(
        aligned.model, folder / 'aligned.building.yaml', name, rmf_picture(aligned, 'plan.png')
    )
    write_dxf(corrected_model(aligned), folder / 'corrected_plan.dxf')
    return [
        RESULT,
        *(f'{name}.yaml' for name in (*maps, 'corrected_plan_confidence')),
        'corrected_plan.dxf',
        'differences.geojson',
        'aligned.building.yaml',
    ]


def write_confidence(corrected: CorrectedPlan, path: Path) -> None:
    """
    Write how sure the corrected plan is as a map_server map of mode ``scale``.

    Its occupancy is the probability in per cent that the drawing is wrong at a cell: 0 where
    the robot map agrees, more where it contradicts, -1 where nothing was observed.
    """
    seen = corrected.wrong >= 0.0
    shade = np.where(seen, np.rint(255.0 * (1.0 - corrected.wrong)), 205.0)
    pixels = np.stack([shade, np.where(seen, 255.0, 0.0)], axis=-1).astype(np.uint8)
    image = path.with_suffix('.png')
    Image.fromarray(pixels[::-1], mode='LA').save(image)
    pose = corrected.grid.T_frame_grid
    fields: dict[str, Any] = {
        'image': image.name,
        'mode': 'scale',
        'resolution': float(corrected.grid.resolution),
        'origin': [pose.x, pose.y, pose.yaw],
        'negate': 0,
        'occupied_thresh': 1.0,
        'free_thresh': 0.0,
    }
    path.write_text(yaml.safe_dump(fields, sort_keys=False), encoding='utf-8')


def rmf_picture(aligned: Alignment, filename: str) -> RmfPicture:
    """Return the plan's picture for Open-RMF with the robot map as a layer, by a similarity."""
    grid = aligned.plan.grid
    metres_per_pixel = grid.resolution * aligned.metres
    A_pixel_plan = _HALF_PIXEL @ pixel_to_xy(grid).inv()
    to_corner = pixel_to_xy(aligned.robot) @ _HALF_PIXEL.inv()
    A_pixel_layer = A_pixel_plan @ aligned.S_plan_map @ to_corner
    layer = RmfLayer('robot_map.png', _rows(A_pixel_layer) * metres_per_pixel)
    return RmfPicture(
        filename, _rows(A_pixel_plan), metres_per_pixel, grid.shape[1], {_LAYER: layer}
    )


def _rows(A: Affine2D) -> NDArray[np.float64]:
    return np.asarray(A.matrix[:2])
