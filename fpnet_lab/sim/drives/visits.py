# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Inputs of a recording: a building, a tour through it, and the robot's floorplan.

Buildings come from the plan generator, from a user's own floorplan, or from a mesh.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import ConfigError, MapFormatError
from fpnet_core.geometry import Affine2D
from fpnet_core.raster.rays import values_at
from fpnet_core.types import FREE, UNKNOWN, GridMap
from fpnet_lab.sim.buildings.building import Building, extrude
from fpnet_lab.sim.buildings.fittings import BuildingStyle
from fpnet_lab.sim.buildings.meshes import TriangleMesh, merge_meshes
from fpnet_lab.sim.drawn.distort import DrawnPlan, laid_elsewhere
from fpnet_lab.sim.drawn.render import render_plan
from fpnet_lab.sim.drives.driving import Tour
from fpnet_lab.sim.drives.mesh_tours import plan_mesh_tour
from fpnet_lab.sim.drives.mesh_worlds import survey_mesh
from fpnet_lab.sim.drives.tours import TourLimits, plan_tour
from fpnet_lab.sim.lidars.sensors import SENSORS, SensorModel
from fpnet_lab.sim.plans import generate_plan
from fpnet_lab.sim.plans.traced import plan_from_grid
from fpnet_lab.sim.types import BuildingPlan

DEFAULT_FAMILIES = (
    'double_corridor',
    'racetrack',
    'branched',
    'diagonal',
    'bent',
    'curved_facade',
    'bays',
    'central_hall',
)
"""Families sampled by default: rooms along corridors, without built-in symmetry."""

_PLAN_ATTEMPTS = 20  # numerical
# Chosen, not measured:
_TOUR_CLEARANCE_M = 0.45  # minimum distance of furniture from the robot's path
_SHORTEST_OWN_TOUR_S = 10.0  # a user's plan may be a small flat
_DRAWN_WALL_M = (0.06, 0.3)  # thickness of a drawing's walls
_SHOWN_SHARE = 0.7  # minimum share of a mesh tour that is free in the floorplan


@dataclass(frozen=True)
class RecordingOptions:
    """
    Options of a simulated recording.

    ``family`` is a key of ``FAMILIES`` (None samples one of ``DEFAULT_FAMILIES``); ``rooms``
    bounds the number of rooms without corridors; both apply to generated buildings. ``style`` is
    the style of extrusion. The drawing's x and y stretch and its pixel size [m] are sampled
    uniformly from their ranges.
    """

    family: str | None = None
    rooms: tuple[int, int] = (12, 45)
    is_furnished: bool = True
    style: BuildingStyle = field(default_factory=BuildingStyle)
    stretch: tuple[float, float] = (0.96, 1.04)
    resolution_m: tuple[float, float] = (0.03, 0.08)
    lidar: SensorModel = SENSORS['beams32']
    limits: TourLimits = field(default_factory=TourLimits)


@dataclass(frozen=True, eq=False)
class Visit:
    """
    A building, a tour and a floorplan of the building.

    ``A_plan_building`` maps true metres to nominal metres of the floorplan's frame ``plan``.
    """

    building: Building
    tour: Tour
    floorplan: GridMap
    A_plan_building: Affine2D


def generated_visit(seed: int, options: RecordingOptions) -> Visit:
    """
    Generate a building, a tour, and a stretched, redrawn floorplan with another origin.

    Raises
    ------
    ConfigError
        If the family is unknown, or no plan of it has enough rooms and a tour.
    """
    layout_rng, contents_rng, drawing_rng = _streams(seed)
    plan, tour = _draw_plan_and_tour(layout_rng, options)
    building = _furnished(plan, tour, contents_rng, options)
    drawn = _draw_floorplan(plan, drawing_rng, options)
    return Visit(building, tour, drawn.grid, drawn.A_plan_building)


def traced_visit(seed: int, options: RecordingOptions, floorplan: GridMap) -> Visit:
    """
    Extrude the building shown in a floorplan; the robot gets the floorplan itself.

    The building's size differs slightly from the drawing, with a random stretch as for generated
    buildings. A small plan may have a shorter tour than ``options.limits``.

    Raises
    ------
    MapFormatError, ConfigError
        If the floorplan has no rooms, or no tour through two of them is found.
    """
    layout_rng, contents_rng, drawing_rng = _streams(seed)
    stretch = drawing_rng.uniform(*options.stretch, size=2)
    A_plan_building = Affine2D(np.diag(stretch), np.zeros(2))
    plan = plan_from_grid(floorplan).mapped(A_plan_building.inv())
    tour = _longest_tour(plan, layout_rng, options)
    building = _furnished(plan, tour, contents_rng, options)
    return Visit(building, tour, floorplan, A_plan_building)


def mesh_visit(
    seed: int, options: RecordingOptions, mesh: TriangleMesh, floorplan: GridMap | None = None
) -> Visit:
    """
    Plan a tour through an unmodified mesh, without added furniture.

    Parameters
    ----------
    seed : seed of the tour
    options : only the tour's limits are used
    mesh : in metres, z up
    floorplan : in the mesh's x and y [m]; None uses the mesh's free space

    Raises
    ------
    MapFormatError
        If the mesh has no drivable indoor space, or the floorplan shows another building.
    """
    world = survey_mesh(mesh)
    tour = plan_mesh_tour(world, _streams(seed)[0], options.limits)
    floorplan = floorplan or world.floorplan()
    shown = _share_on_free(floorplan, tour.xy)
    if shown < _SHOWN_SHARE:
        raise MapFormatError(
            f'only {100.0 * shown:.0f}% of a tour through the mesh are free space in the '
            'floorplan; expected a plan of the same building in the same x and y'
        )
    plan = plan_from_grid(floorplan)
    line = tour.line()
    visited = [k for k, outline in enumerate(plan.outlines) if outline.intersects(line)]
    building = Building(plan, world.mesh, world.ceiling, merge_meshes([]))
    return Visit(building, replace(tour, rooms=tuple(visited)), floorplan, Affine2D.identity())


def _streams(seed: int) -> tuple[np.random.Generator, np.random.Generator, np.random.Generator]:
    """Return the random generators of layout, contents and drawing."""
    a, b, c = np.random.SeedSequence(seed).spawn(3)
    return np.random.default_rng(a), np.random.default_rng(b), np.random.default_rng(c)


def _furnished(
    plan: BuildingPlan, tour: Tour, rng: np.random.Generator, options: RecordingOptions
) -> Building:
    keep_clear = tour.line().buffer(_TOUR_CLEARANCE_M)
    return extrude(
        plan,
        rng,
        keep_clear=keep_clear,
        is_furnished=options.is_furnished,
        style=options.style,
    )


def _draw_plan_and_tour(
    rng: np.random.Generator, options: RecordingOptions
) -> tuple[BuildingPlan, Tour]:
    """Generate plans until one has enough rooms, a corridor and a tour."""
    reason = ''
    for _ in range(_PLAN_ATTEMPTS):
        family = options.family or str(rng.choice(DEFAULT_FAMILIES))
        plan = generate_plan(rng, family, min_rooms=options.rooms[0] + 1)
        count = sum(room.kind == 'room' for room in plan.rooms)
        if not options.rooms[0] <= count <= options.rooms[1] or count == len(plan.rooms):
            reason = f'the last plan has {count} rooms and {len(plan.rooms) - count} corridors'
            continue
        try:
            return plan, plan_tour(plan, rng, options.limits)
        except ConfigError as error:
            reason = str(error)
    raise ConfigError(
        f'no plan of family {options.family or "any"} with {options.rooms[0]} to '
        f'{options.rooms[1]} rooms, a corridor and a tour in {_PLAN_ATTEMPTS} attempts: {reason}'
    )


def _longest_tour(plan: BuildingPlan, rng: np.random.Generator, options: RecordingOptions) -> Tour:
    """Return a tour through as many rooms as requested or possible, but at least two."""
    count = sum(room.kind == 'room' for room in plan.rooms)
    wanted = min(options.limits.rooms, count)
    shortest_s = min(options.limits.shortest_s, _SHORTEST_OWN_TOUR_S)
    for rooms in range(wanted, 1, -1):
        limits = replace(options.limits, rooms=rooms, shortest_s=shortest_s)
        try:
            return plan_tour(plan, rng, limits)
        except ConfigError:
            continue
    raise ConfigError(
        f'the floorplan has {len(plan.rooms)} rooms and {len(plan.doors)} doors, but no path '
        'for a robot between two rooms; check its metres per pixel and its doors'
    )


def _draw_floorplan(
    plan: BuildingPlan, rng: np.random.Generator, options: RecordingOptions
) -> DrawnPlan:
    """Draw the stretched building, with a random origin and rotation of the sheet."""
    stretch = Affine2D(np.diag(rng.uniform(*options.stretch, size=2)), np.zeros(2))
    sheet = render_plan(
        plan,
        resolution_m=float(rng.uniform(*options.resolution_m)),
        wall_m=float(rng.uniform(*_DRAWN_WALL_M)),
        T_plan_building=stretch,
    )
    return laid_elsewhere(sheet, stretch, rng)


def _share_on_free(grid: GridMap, xy: NDArray[np.float64]) -> float:
    return float((values_at(grid.cells, grid.xy_to_rc(xy), UNKNOWN) == FREE).mean())
