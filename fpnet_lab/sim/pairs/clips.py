# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Robot maps sampled as in the paper: a clipped part of the storey's map with rough walls.

No rays are cast: maps are cheap and differ from the drawing only as described in the paper:
"its partial samples with various noise and clips" (section V-A1). For realistic robot maps see
:mod:`fpnet_lab.sim.pairs.explore`.
"""

from __future__ import annotations

from dataclasses import replace

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.raster.morphology import grown
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, GridMap, Submap
from fpnet_lab.sim.buildings.furnishing import furnish_loosely
from fpnet_lab.sim.config import ClipConfig
from fpnet_lab.sim.drawn.distort import warp_map
from fpnet_lab.sim.drawn.drawings import SHIFT_M
from fpnet_lab.sim.drawn.render import door_outline, fill_polygons, render_plan, room_outlines
from fpnet_lab.sim.drawn.rough import roughened
from fpnet_lab.sim.plans.sources import NamedPlan
from fpnet_lab.sim.types import BuildingPlan

# Chosen, not measured:
_SCAN_HEIGHT_M = 0.4  # height of the slice through furniture


def clip_map(
    storey: NamedPlan,
    area: NDArray[np.float64] | None,
    rng: np.random.Generator,
    config: ClipConfig,
) -> tuple[Submap, SE2]:
    """
    Return a submap clipped from a storey's map in a random frame, and ``T_submap_building``.

    Parameters
    ----------
    storey : the building; if it has a raster, that is the map
    area : (4, 2) part of the building to select rooms from [m]; None: the whole building
    rng : random generator
    config : size and roughness of the clip
    """
    x, y = rng.uniform(-SHIFT_M, SHIFT_M, 2)
    T = SE2.from_xy_yaw(x, y, rng.uniform(-np.pi, np.pi))
    A = Affine2D(T.linear, T.translation)
    if storey.raster is None:
        grid = render_plan(storey.plan, float(rng.choice(config.resolution_m)), T_plan_building=A)
    else:
        grid = warp_map(storey.raster, A)
    rooms = draw_rooms(storey.plan, area, rng, config)
    shown = _shown(grid, storey.plan, rooms, A)
    if rng.random() < config.clipped:
        shown &= _half_plane(shown, rng, config)
    grid, shown = _window(grid, shown)
    cells = grid.cells.copy()
    if rng.random() < config.furnished:
        pieces = furnish_loosely(storey.plan, rng).met_at(_SCAN_HEIGHT_M)
        stands = _covered(grid, [A.apply(piece) for piece in pieces])
        cells[stands & (cells == FREE)] = OCCUPIED
    cells = roughened(cells, rng, config)
    cells[~shown] = UNKNOWN
    path = np.stack([A.apply(storey.plan.rooms[room].polygon.mean(axis=0)) for room in rooms])
    lintel = np.zeros(cells.shape, dtype=np.bool_)
    return Submap(replace(grid, cells=cells, frame='submap'), lintel, path), T


def draw_rooms(
    plan: BuildingPlan,
    area: NDArray[np.float64] | None,
    rng: np.random.Generator,
    config: ClipConfig,
) -> list[int]:
    """Sample connected rooms of the storey, with centres inside ``area`` if any are."""
    graph = nx.Graph(plan.room_graph())
    if area is not None:
        middles = np.array([room.polygon.mean(axis=0) for room in plan.rooms])
        low, high = area.min(axis=0), area.max(axis=0)
        inside = ((middles >= low) & (middles <= high)).all(axis=1)
        if inside.any():
            graph = nx.Graph(graph.subgraph(np.flatnonzero(inside).tolist()))
    first = int(rng.choice(sorted(graph)))
    share = rng.uniform(*config.share)
    wanted = max(config.min_rooms, round(share * len(nx.node_connected_component(graph, first))))
    chosen, border = [first], sorted(graph[first])
    while border and len(chosen) < wanted:
        room = border.pop(int(rng.integers(len(border))))
        chosen.append(room)
        border += [r for r in sorted(graph[room]) if r not in chosen and r not in border]
    return chosen


def _shown(grid: GridMap, plan: BuildingPlan, rooms: list[int], A: Affine2D) -> NDArray[np.bool_]:
    """Return the cells (H, W) of the rooms, their doorways and the surrounding walls."""
    outlines = room_outlines(plan, plan.wall_m)
    rings = [outlines[room] for room in rooms]
    rings += [
        door_outline(door, plan.wall_m, plan.wall_m)
        for door in plan.doors
        if not set(rooms).isdisjoint(door.rooms)
    ]
    covered = _covered(grid, [A.apply(ring) for ring in rings])
    reach = int(np.ceil(plan.wall_m / grid.resolution))
    # Dilation at a doorway also reaches the floor of the next room; keep walls only.
    return np.asarray(covered | (grown(covered, reach) & (grid.cells == OCCUPIED)))


def _covered(grid: GridMap, rings: list[NDArray[np.float64]]) -> NDArray[np.bool_]:
    """Return the cells (H, W) inside any of the rings, given in the grid's frame [m]."""
    raster = np.zeros(grid.shape, np.uint8)
    fill_polygons(raster, [grid.xy_to_rc(ring)[:, ::-1] + 0.5 for ring in rings], 1, True)
    return raster > 0


def _half_plane(
    shown: NDArray[np.bool_], rng: np.random.Generator, config: ClipConfig
) -> NDArray[np.bool_]:
    """Return the cells on one side of a random line that removes a share of ``shown``."""
    angle = rng.uniform(-np.pi, np.pi)
    rows, cols = np.arange(shown.shape[0]), np.arange(shown.shape[1])
    along = np.cos(angle) * cols[None] + np.sin(angle) * rows[:, None]
    limit = np.quantile(along[shown], 1.0 - rng.uniform(0.0, config.clip_share))
    return np.asarray(along <= limit)


def _window(grid: GridMap, shown: NDArray[np.bool_]) -> tuple[GridMap, NDArray[np.bool_]]:
    """Crop the grid and the mask ``shown`` to the shown cells plus a border of one cell."""
    rc = np.argwhere(shown)
    low, high = np.maximum(rc.min(axis=0) - 1, 0), rc.max(axis=0) + 2
    part = slice(low[0], high[0]), slice(low[1], high[1])
    x, y = (low[::-1] * grid.resolution).tolist()
    pose = grid.T_frame_grid @ SE2.from_xy_yaw(x, y, 0.0)
    return replace(grid, cells=grid.cells[part], T_frame_grid=pose), shown[part]
