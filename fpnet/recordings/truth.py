# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reader for ground truth poses of a recording."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fpnet.recordings.trajectories import read_tum
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import Affine2D
from fpnet_core.plain_files import regular
from fpnet_core.trajectory import PlanarTrajectory

TRUTH_POSES_NAME, TRUTH_NAME = 'truth.tum', 'truth.json'
"""Files of a simulated recording besides its bag and floorplan."""

RESOLUTION_KEY = 'floorplan_resolution_m'
"""JSON key of the floorplan's resolution, which defines the nominal metres."""

_SAME = 1e-3  # numerical: relative difference up to which resolutions count as equal


def read_truth(path: Path) -> tuple[PlanarTrajectory, Affine2D]:
    """
    Return true poses and the map from their metres to the floorplan's nominal ones.

    ``path`` is a TUM file: either of a simulated recording, with the floorplan's distortion in
    ``truth.json`` next to it, or of poses in the floorplan's frame.

    Raises
    ------
    FpnetError
        If a file is missing or damaged.
    """
    beside = path.with_name(TRUTH_NAME)
    is_simulated = path.name == TRUTH_POSES_NAME and beside.exists()
    return read_planar(path), read_distortion(beside) if is_simulated else Affine2D.identity()


def check_truth(path: Path, resolution_m: float) -> None:
    """
    Check that a simulated recording's true poses match the resolution of the floorplan.

    Raises
    ------
    FpnetError
        If the resolutions differ, and with them the nominal metres.
    """
    beside = path.with_name(TRUTH_NAME)
    if path.name != TRUTH_POSES_NAME or not beside.exists():
        return
    stated = read_json(beside, 'record it again').get(RESOLUTION_KEY)
    if isinstance(stated, float) and abs(resolution_m / stated - 1.0) > _SAME:
        raise FpnetError(
            f'{path} is for the floorplan at {stated:.5g} m per pixel, but it was read at '
            f'{resolution_m:.5g}; pass its YAML without --resolution, or leave out --truth'
        )


def read_distortion(path: Path) -> Affine2D:
    """
    Return the map from a building's metres to a floorplan's nominal ones, from ``truth.json``.

    Raises
    ------
    FpnetError
        If the file is missing or damaged.
    """
    values = read_json(path, 'record it again')
    try:
        return Affine2D.from_matrix(values['A_plan_building'])
    except (KeyError, TypeError, ValueError) as error:
        raise FpnetError(f'{path}: A_plan_building: {error}; record it again') from None


def read_planar(path: Path) -> PlanarTrajectory:
    """
    Read the poses of a TUM file; an empty file gives an empty trajectory.

    Raises
    ------
    FpnetError
        If the file is missing or damaged.
    """
    if path.is_file() and not path.read_bytes().strip():
        return PlanarTrajectory.empty()
    poses = read_tum(path)
    return PlanarTrajectory(poses.stamps_ns, poses.xy, poses.yaw)


def read_json(path: Path, remedy: str) -> dict[str, Any]:
    """
    Return the object in a JSON file; ``remedy`` is appended to error messages.

    Raises
    ------
    FpnetError
        If the file is missing or not a JSON object.
    """
    try:
        values = json.loads(regular(path).read_text(encoding='utf-8'))
    except OSError as error:
        raise FpnetError(f'cannot read {path}: {error.strerror}; {remedy}') from None
    except ValueError as error:
        raise FpnetError(f'{path} is not valid JSON ({error}); {remedy}') from None
    if not isinstance(values, dict):
        raise FpnetError(f'{path} is not a JSON object; {remedy}')
    return values
