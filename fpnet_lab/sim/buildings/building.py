# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Extrusion of a layout for ray casting: walls, doors, windows, floor, ceiling, furniture.

Doors are lower than the ceiling: the wall above a door (its lintel) distinguishes a door from a
narrow passage in lidar data. Frame ``building``: x and y of the plan, z = 0 on the floor.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import shapely

from fpnet_core.errors import ConfigError
from fpnet_lab.sim.buildings.fittings import BuildingStyle, Pane, cut_windows, hang_leaves
from fpnet_lab.sim.buildings.furnishing import furnish
from fpnet_lab.sim.buildings.furniture import FurniturePiece, joined
from fpnet_lab.sim.buildings.meshes import (
    TriangleMesh,
    extrude_polygon,
    horizontal_sheet,
    merge_meshes,
)
from fpnet_lab.sim.buildings.openings import opening_polygon, walkable_area
from fpnet_lab.sim.types import BuildingPlan

OUTER_WALL_M = 0.3  # chosen

_GLASS_M = 0.005  # half the thickness of a pane; chosen


@dataclass(frozen=True, eq=False)
class Building:
    """
    An extruded plan, frame ``building`` [m].

    ``walls`` include lintels and door leaves, ``shell`` is floor and ceiling, ``contents`` is all
    furniture; most rays pass ``glass``.
    """

    plan: BuildingPlan
    walls: TriangleMesh
    shell: TriangleMesh
    contents: TriangleMesh
    furniture: tuple[FurniturePiece, ...] = ()
    glass: TriangleMesh = field(default_factory=lambda: merge_meshes([]))

    @property
    def parts(self) -> tuple[TriangleMesh, TriangleMesh, TriangleMesh]:
        """Walls, shell and contents, in the order of the lidar's reflectivities."""
        return self.walls, self.shell, self.contents


def extrude(
    plan: BuildingPlan,
    rng: np.random.Generator,
    *,
    keep_clear: shapely.Geometry | None = None,
    is_furnished: bool = True,
    style: BuildingStyle | None = None,
) -> Building:
    """
    Extrude a plan's walls, add doors and windows, and furnish its rooms.

    Parameters
    ----------
    plan : BuildingPlan
    rng : numpy.random.Generator
        Random generator of furniture, heights, leaves and windows.
    keep_clear : shapely geometry, frame ``building``
        Area without furniture and leaves, for example the robot's path with its clearance.
    is_furnished : bool
        If False, rooms are empty.
    style : BuildingStyle
        Default: lintels, without leaves and windows.

    Raises
    ------
    ConfigError
        If the lintel is not between floor and ceiling.
    """
    style = style or BuildingStyle()
    ceiling_m, lintel_m = (float(rng.uniform(*r)) for r in (style.ceiling_m, style.lintel_m))
    if not 0.0 < lintel_m < ceiling_m:
        raise ConfigError(
            f'the lintel at {lintel_m:.2f} m must lie below the ceiling at {ceiling_m:.2f} m'
        )
    furniture = furnish(plan, rng, keep_clear) if is_furnished else ()
    panes = cut_windows(plan, style, OUTER_WALL_M, rng)
    has_lintel = [not door.is_open and rng.random() >= style.frameless for door in plan.doors]
    leaves = hang_leaves(plan, style, lintel_m, rng, keep_clear)
    lintels = [
        extrude_polygon(opening_polygon(plan, door), lintel_m, ceiling_m)
        for door, is_low in zip(plan.doors, has_lintel, strict=True)
        if is_low
    ]
    hung = [extrude_polygon(base, 0.0, top_m) for base, top_m in leaves]
    return Building(
        plan=plan,
        walls=merge_meshes([_walls(plan, ceiling_m, panes), *lintels, *hung]),
        shell=_shell(plan, ceiling_m),
        contents=joined([piece.boxes for piece in furniture]).mesh(),
        furniture=furniture,
        glass=merge_meshes(
            [
                extrude_polygon(pane.glass.buffer(_GLASS_M, cap_style='flat'), *pane[2:])
                for pane in panes
            ]
        ),
    )


def _walls(plan: BuildingPlan, ceiling_m: float, panes: list[Pane]) -> TriangleMesh:
    """Return all solid parts from floor to ceiling, without the holes of windows."""
    open_area = walkable_area(plan)
    hull = open_area.buffer(OUTER_WALL_M, join_style='mitre')
    solid = shapely.difference(_without_courtyards(hull), open_area)
    holes = [shapely.intersection(pane.hole, solid) for pane in panes]
    full = shapely.difference(solid, shapely.union_all(holes)) if holes else solid
    below = [extrude_polygon(hole, 0.0, p.bottom_m) for hole, p in zip(holes, panes, strict=True)]
    above = [
        extrude_polygon(hole, p.top_m, ceiling_m) for hole, p in zip(holes, panes, strict=True)
    ]
    return merge_meshes([extrude_polygon(full, 0.0, ceiling_m), *below, *above])


def _without_courtyards(hull: shapely.Geometry) -> shapely.Geometry:
    """Fill holes, so that all space between rooms is solid."""
    parts = shapely.get_parts(hull).tolist()
    return shapely.union_all([shapely.Polygon(part.exterior) for part in parts])


def _shell(plan: BuildingPlan, ceiling_m: float) -> TriangleMesh:
    """Return floor and ceiling as two rectangles that cover all walls."""
    (x0, y0), (x1, y1) = plan.extent + np.array([[-OUTER_WALL_M], [OUTER_WALL_M]])
    area = shapely.box(x0, y0, x1, y1)
    return merge_meshes(
        [horizontal_sheet(area, 0.0, faces_up=True), horizontal_sheet(area, ceiling_m, False)]
    )
