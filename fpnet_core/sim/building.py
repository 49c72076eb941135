# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
From a layout to a building that can be ray-cast: walls, doors, floor, ceiling, furniture.

Doors are lower than the ceiling: the wall above a door (its lintel) is what tells a door from a
narrow place in a lidar's view. Frame ``building``: x and y of the plan, z = 0 on the floor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from fpnet_core.sim.furniture import FurniturePiece, furnish
from fpnet_core.sim.meshes import (
    TriangleMesh,
    extrude_polygon,
    horizontal_sheet,
    merge_meshes,
)
from fpnet_core.sim.openings import opening_polygon, walkable_area
from fpnet_core.sim.types import BuildingPlan

CEILING_M = 2.7
LINTEL_M = 2.05
"""Heights of the ceiling and of a door's opening above the floor."""

OUTER_WALL_M = 0.3


@dataclass(frozen=True, eq=False)
class Building:
    """
    An extruded plan, frame ``building`` [m].

    ``walls`` include lintels, ``shell`` is floor and ceiling, ``contents`` is all furniture.
    """

    plan: BuildingPlan
    walls: TriangleMesh
    shell: TriangleMesh
    contents: TriangleMesh
    furniture: tuple[FurniturePiece, ...]

    @property
    def parts(self) -> tuple[TriangleMesh, TriangleMesh, TriangleMesh]:
        """Walls, shell and contents: the order of the parts' reflectivities in a lidar."""
        return self.walls, self.shell, self.contents


def extrude(
    plan: BuildingPlan,
    rng: np.random.Generator,
    *,
    keep_clear: shapely.Geometry | None = None,
    is_furnished: bool = True,
    ceiling_m: float = CEILING_M,
    lintel_m: float = LINTEL_M,
) -> Building:
    """
    Raise a plan's walls and furnish its rooms.

    Parameters
    ----------
    plan : BuildingPlan
    rng : numpy.random.Generator
        Draws the furniture.
    keep_clear : shapely geometry, frame ``building``
        Where no furniture may stand, such as the robot's path with its clearance.
    is_furnished : bool
        False leaves the rooms empty.
    ceiling_m, lintel_m : float
        Heights of the ceiling and of door openings above the floor [m].

    Raises
    ------
    ValueError
        If the lintel is not between floor and ceiling.
    """
    if not 0.0 < lintel_m < ceiling_m:
        raise ValueError(f'lintel at {lintel_m} m must lie below the ceiling at {ceiling_m} m')
    furniture = furnish(plan, rng, keep_clear) if is_furnished else ()
    return Building(
        plan=plan,
        walls=_walls(plan, ceiling_m, lintel_m),
        shell=_shell(plan, ceiling_m),
        contents=merge_meshes([piece.mesh() for piece in furniture]),
        furniture=furniture,
    )


def _walls(plan: BuildingPlan, ceiling_m: float, lintel_m: float) -> TriangleMesh:
    """Return everything solid from floor to ceiling, and the lintels above doors."""
    open_area = walkable_area(plan)
    hull = open_area.buffer(OUTER_WALL_M, join_style='mitre')
    lintels = [
        extrude_polygon(opening_polygon(plan, door), lintel_m, ceiling_m)
        for door in plan.doors
        if not door.is_open
    ]
    solid = shapely.difference(_without_courtyards(hull), open_area)
    return merge_meshes([extrude_polygon(solid, 0.0, ceiling_m), *lintels])


def _without_courtyards(hull: shapely.Geometry) -> shapely.Geometry:
    """Fill holes: what lies between rooms but is no room is solid."""
    parts = shapely.get_parts(hull).tolist()
    return shapely.union_all([shapely.Polygon(part.exterior) for part in parts])


def _shell(plan: BuildingPlan, ceiling_m: float) -> TriangleMesh:
    """Return floor and ceiling as two rectangles that reach below and above all walls."""
    (x0, y0), (x1, y1) = plan.extent + np.array([[-OUTER_WALL_M], [OUTER_WALL_M]])
    area = shapely.box(x0, y0, x1, y1)
    return merge_meshes(
        [horizontal_sheet(area, 0.0, faces_up=True), horizontal_sheet(area, ceiling_m, False)]
    )
