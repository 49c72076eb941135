# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Real floorplans with real robot maps of the same buildings, complete or cropped.

The pairs and their fitted transforms are those of the shared data (``bormann``, ``carpin``,
``priormaps``, ``radish``, ``gdc``, ``g4s``). Every pair, and every floorplan without a robot map,
belongs to one split; the split is by building.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
import json
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.graph import MCP_Geometric

from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.io.maps import read_map, states_scale
from fpnet_core.raster.blocks import unblocked
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.pixels import pixel_to_xy
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap
from fpnet_lab.sim.population.floors import TUNE_FLOORS

SOURCES = ('bormann', 'carpin', 'priormaps', 'radish', 'gdc', 'g4s')

TUNE_PLANS = (*TUNE_FLOORS, 'basic_filled', 'office_filled', 'gdc1', 'gdc2', 'g4s')
"""Floorplans of the development split; all others are in the test split."""

DISTORTED_PLANS = ('Freiburg79_scan', 'lab_b_scan', 'lab_f_scan')
"""Floorplans that no similarity aligns with their robot maps, according to the data's notes."""

WHOLE = 'whole'
"""Band of the unchanged pairs, neither cropped nor rotated."""

BANDS: dict[str, tuple[float, float]] = {
    '50-100': (0.5, 1.0),
    '20-35': (0.2, 0.35),
    '10-20': (0.1, 0.2),
}
"""Shares of the robot map's free space kept by a crop. Chosen."""

# Chosen, not measured:
SCALES = (0.7, 1.4)
_DRAWN_ONLY = 'bormann'  # also holds floorplans without a robot map
_ONE_PROJECT = 'priormaps'
_SERIES = ('Freiburg', 'gdc', 'office')  # a campus, storeys of one house, one set of drawings
_WALL_REACH_M = 0.4  # distance to kept free space up to which walls are kept
_CUT_CELL = 4  # numerical: cells per node of the graph on which a crop grows
_OCCUPIED_SHARE = 0.35  # least share of a rotated wall cell; thin walls must stay closed
_FREE_SHARE = 0.5


@dataclass(frozen=True, eq=False)
class BuildingFloorplan:
    """Floorplan of a ``building``; plans of the same ``architect`` look similar."""

    building: str
    grid: GridMap
    is_metric: bool
    architect: str


@dataclass(frozen=True, eq=False)
class RobotPair:
    """
    A floorplan and a robot map; ``A_plan_robot`` maps the map's nominal metres to the plan's.

    ``building`` is the name of the floorplan; ``kept`` is the remaining share of the robot map's
    free space. ``is_metric``: both files state their scale. ``files`` are floorplan and robot map.
    """

    name: str
    plan: GridMap
    robot: GridMap
    A_plan_robot: Affine2D
    kept: float = 1.0
    building: str = ''
    is_metric: bool = False
    architect: str = ''
    files: tuple[Path, ...] = ()

    @property
    def drawing(self) -> BuildingFloorplan:
        """The floorplan of the pair."""
        return BuildingFloorplan(self.building, self.plan, self.is_metric, self.architect)

    @property
    def is_distorted(self) -> bool:
        """Return whether the data's notes mark the floorplan as distorted."""
        return self.building in DISTORTED_PLANS


def read_robot_pairs(data: Path, split: str) -> tuple[RobotPair, ...]:
    """
    Load the pairs of one split of the shared data, ``tune`` or ``report``.

    Raises
    ------
    FpnetError
        If the folder is missing or incomplete, or the split does not exist.
    """
    _check_half(split)
    pairs: list[RobotPair] = []
    for source in SOURCES:
        folder = data / source
        try:
            entries = json.loads((folder / 'pairs.json').read_text(encoding='utf-8'))['pairs']
        except (OSError, ValueError, KeyError) as error:
            raise FpnetError(f'cannot read the pairs of {folder}: {error!r}') from None
        pairs += [
            _read_pair(folder, entry)
            for entry in entries
            if _half(Path(entry['floorplan'])) == split
        ]
    return tuple(pairs)


def read_drawings(
    data: Path, split: str, pairs: Sequence[RobotPair]
) -> tuple[BuildingFloorplan, ...]:
    """Return each floorplan of one split once: those of ``pairs`` and those without a pair."""
    _check_half(split)
    drawings = {pair.building: pair.drawing for pair in pairs}
    for path in sorted((data / _DRAWN_ONLY / 'floorplan').glob('*.png')):
        name = path.stem
        if name not in drawings and _half(path) == split:
            drawings[name] = BuildingFloorplan(
                name, read_map(path), False, _architect(_DRAWN_ONLY, name)
            )
    return tuple(drawings.values())


def foreign_drawings(
    own: BuildingFloorplan,
    drawings: Sequence[BuildingFloorplan],
    rng: np.random.Generator,
    count: int,
) -> tuple[BuildingFloorplan, ...]:
    """
    Choose ``count`` floorplans of other buildings, or all there are.

    One of them is by the architect of ``own`` if possible; the others are not.
    """
    order = rng.permutation(len(drawings))
    others = [drawings[i] for i in order if drawings[i].building != own.building]
    alike = [drawing for drawing in others if drawing.architect == own.architect]
    unlike = [drawing for drawing in others if drawing.architect != own.architect]
    return (*alike[:1], *unlike, *alike[1:])[:count]


def _check_half(split: str) -> None:
    if split not in ('tune', 'report'):
        raise FpnetError(f'no split {split!r} of the data; expected tune or report')


def _half(floorplan: Path) -> str:
    return 'tune' if floorplan.stem in TUNE_PLANS else 'report'


def _architect(source: str, building: str) -> str:
    """Return an identifier shared by all floorplans of the same architect."""
    return source if source == _ONE_PROJECT else architect_of(building)


def architect_of(building: str) -> str:
    """Return the series of drawings of a real building, or the building's name."""
    return next((series for series in _SERIES if building.startswith(series)), building)


def _read_pair(folder: Path, entry: dict[str, str]) -> RobotPair:
    paths = [_best_of(folder / entry[key]) for key in ('floorplan', 'robot_map')]
    plan, robot = map(read_map, paths)
    between = Affine2D.from_matrix(np.array(entry['affine_2x3'], dtype=np.float64))
    building = paths[0].stem
    return RobotPair(
        entry['id'],
        plan,
        robot,
        A_plan_robot=pixel_to_xy(plan) @ between @ pixel_to_xy(robot).inv(),
        building=building,
        is_metric=all(map(states_scale, paths)),
        architect=_architect(folder.name, building),
        files=tuple(paths),
    )


def _best_of(image: Path) -> Path:
    """Return the map_server YAML next to an image if it exists: it states the scale."""
    beside = image.with_suffix('.yaml')
    return beside if beside.exists() else image


def varied(pair: RobotPair, rng: np.random.Generator, kept: tuple[float, float]) -> RobotPair:
    """
    Crop the robot map to a connected part, rotate it randomly and change its nominal scale.

    A stated scale is kept. ``kept`` is the range of the share of free space to keep.
    """
    share = float(rng.uniform(*kept))
    cut = _cut(pair.robot, rng, share)
    turned, A_turned_robot = _turned(cut, float(rng.uniform(-np.pi, np.pi)))
    factor = 1.0 if pair.is_metric else float(np.exp(rng.uniform(*np.log(SCALES))))
    scaled = replace(
        turned,
        resolution=turned.resolution * factor,
        T_frame_grid=SE2(turned.T_frame_grid.linear, turned.T_frame_grid.translation * factor),
    )
    A_scaled_robot = Affine2D(np.eye(2) * factor, np.zeros(2)) @ A_turned_robot
    return replace(
        pair, robot=scaled, A_plan_robot=pair.A_plan_robot @ A_scaled_robot.inv(), kept=share
    )


def _cut(grid: GridMap, rng: np.random.Generator, share: float) -> GridMap:
    """Keep the free cells nearest to a random one by path length, and the walls near them."""
    free = grid.cells == FREE
    height, width = (size // _CUT_CELL for size in free.shape)
    blocks = free[: height * _CUT_CELL, : width * _CUT_CELL]
    passable = blocks.reshape(height, _CUT_CELL, width, _CUT_CELL).mean(axis=(1, 3)) > _FREE_SHARE
    nodes = np.argwhere(passable)
    start = nodes[rng.integers(len(nodes))]
    costs, _ = MCP_Geometric(np.where(passable, 1.0, np.inf)).find_costs([start])
    far = unblocked(costs, _CUT_CELL)
    cost = np.full(free.shape, np.inf)
    cost[: far.shape[0], : far.shape[1]] = far
    limit = np.sort(cost[free])[min(int(share * free.sum()), free.sum() - 1)]
    keep_free = free & (cost <= limit) & np.isfinite(cost)
    near = grown(keep_free, max(1, round(_WALL_REACH_M / grid.resolution)))
    cells = np.full_like(grid.cells, UNKNOWN)
    cells[keep_free] = FREE
    cells[(grid.cells == OCCUPIED) & near] = OCCUPIED
    return replace(grid, cells=cells)


def _turned(grid: GridMap, angle: float) -> tuple[GridMap, Affine2D]:
    """Resample the raster rotated by ``angle``; return it and the transform to its frame."""
    height, width = grid.shape
    centre = (width / 2, height / 2)
    matrix = cv2.getRotationMatrix2D(centre, float(np.rad2deg(-angle)), 1.0)
    turn: NDArray[np.float64] = np.asarray(matrix, dtype=np.float64)
    corners = np.array([[0, 0], [width, 0], [0, height], [width, height]], dtype=np.float64)
    placed = corners @ turn[:, :2].T + turn[:, 2]
    turn[:, 2] -= placed.min(axis=0)
    size = tuple(np.ceil(np.ptp(placed, axis=0)).astype(int).tolist())

    def share(value: int) -> NDArray[np.float32]:
        mask = (grid.cells == value).astype(np.float32)
        return np.asarray(cv2.warpAffine(mask, turn, size), dtype=np.float32)

    cells = np.full((size[1], size[0]), UNKNOWN, dtype=grid.cells.dtype)
    cells[share(FREE) > _FREE_SHARE] = FREE
    cells[share(OCCUPIED) > _OCCUPIED_SHARE] = OCCUPIED
    turned = replace(grid, cells=cells)
    # Column and row are x and y of the grid in cells; both rasters share the pose of their frame.
    in_grid = Affine2D(turn[:, :2], turn[:, 2] * grid.resolution)
    return turned, grid.T_frame_grid @ in_grid @ grid.T_frame_grid.inv()
