# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values that the interface returns: the core's, with a short ``repr`` and a plot."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from fpnet.alignment import Alignment
from fpnet.plan_check import PlanCheck
from fpnet.viz.pictures import axes_of, figure_of, html_of
from fpnet_core.differences import Differences
from fpnet_core.drawings.types import Reading
from fpnet_core.drawings.wording import said_of_scale
from fpnet_core.localizer import MapMatch
from fpnet_core.types import Segmentation, Submap

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Value = TypeVar('Value')


def shown_as(shown: type[Value], value: Any) -> Value:
    """Return a frozen value as ``shown``, the subclass that has a plot."""
    return shown(**{field.name: getattr(value, field.name) for field in fields(value)})


class Plan(Reading):
    """A parsed drawing: :class:`fpnet_core.drawings.types.Reading` with a plot."""

    def __repr__(self) -> str:
        """Return size, scale and warnings in one line."""
        height, width = (cells * self.grid.resolution for cells in self.grid.shape)
        doubts = f', warnings: {"; ".join(self.doubts)}' if self.doubts else ''
        return (
            f'<Plan {self.drawing.name}: {width:.0f} x {height:.0f} m, '
            f'{said_of_scale(self.scale)}{doubts}>'
        )

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the plan in metres, on ``ax`` or a new figure."""
        from fpnet.viz.segmentation import draw_grid

        ax = axes_of(ax)
        draw_grid(ax, self.grid)
        return ax

    def _repr_html_(self) -> str:
        return html_of(self, lambda figure: self.plot(figure.add_subplot()))


class Rooms(Segmentation):
    """Rooms and doors: :class:`fpnet_core.types.Segmentation` with a plot."""

    def __repr__(self) -> str:
        """Return counts and area in one line."""
        area_m2 = sum(room.area_m2 for room in self.rooms)
        said = f'{len(self.rooms)} rooms, {area_m2:.0f} m², {len(self.doors)} doors'
        return f'<Rooms: {said if self.rooms else self.reason}>'

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the map, its rooms with their numbers and its doors, in metres."""
        from fpnet.viz.segmentation import draw_grid, draw_segmentation

        ax = axes_of(ax)
        draw_grid(ax, self.grid)
        draw_segmentation(ax, self, with_ids=True)
        return ax

    def _repr_html_(self) -> str:
        return html_of(self, lambda figure: self.plot(figure.add_subplot()))


@dataclass(frozen=True, eq=False)
class RobotMap:
    """A robot map; ``is_metric`` if its metres are true, not nominal."""

    submap: Submap
    is_metric: bool

    def __repr__(self) -> str:
        """Return the free area in one line."""
        metres = 'm²' if self.is_metric else 'm² at a nominal scale'
        return f'<RobotMap: {self.submap.free_area_m2:.0f} {metres} of free space>'

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the map in its metres, on ``ax`` or a new figure."""
        from fpnet.viz.segmentation import draw_grid

        ax = axes_of(ax)
        draw_grid(ax, self.submap.grid)
        return ax

    def _repr_html_(self) -> str:
        return html_of(self, lambda figure: self.plot(figure.add_subplot()))


@dataclass(frozen=True, eq=False)
class Placed:
    """A robot map placed on a drawing, that of ``storey``, and their differences."""

    match: MapMatch
    differences: Differences
    storey: str = ''

    def __repr__(self) -> str:
        """Return the probability, and the number and length of differences, in one line."""
        likely = self.differences.likely
        length_m = sum(each.length_m for each in likely)
        return f'<Placed (p {self.match.probability:.2f}): {len(likely)} differ, {length_m:.0f} m>'

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the plan with the differences, in metres, on ``ax`` or a new figure."""
        from fpnet.viz.differences import draw_differences

        ax = axes_of(ax)
        draw_differences(ax, self.differences)
        return ax

    def _repr_html_(self) -> str:
        return html_of(self, lambda figure: self.plot(figure.add_subplot()))


class Aligned(Alignment):
    """A robot map on a plan: :class:`fpnet.alignment.Alignment` with a plot and files."""

    def __repr__(self) -> str:
        """Return transform and residual in one line."""
        x, y = self.A_plan_map.translation
        walls = self.walls.whole
        return (
            f'<Aligned: x {x:.2f} m, y {y:.2f} m, {np.rad2deg(self.A_plan_map.heading):.1f} deg, '
            f'scale {self.A_plan_map.scale:.3f}; median {walls["median_m"]:.2f} m>'
        )

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the robot map's walls on the plan, coloured by distance to drawn walls."""
        from fpnet.viz.alignment import draw_alignment

        ax = axes_of(ax)
        draw_alignment(ax, self)
        return ax

    def write(self, folder: str | Path) -> list[str]:
        """Write the files of ``fpnet align --out`` into a folder; return their names."""
        from fpnet.alignment.files import PICTURE, write_files
        from fpnet.viz.alignment import save_alignment

        names = write_files(self, Path(folder))
        save_alignment(self, Path(folder) / PICTURE)
        return [*names, PICTURE]

    def _repr_html_(self) -> str:
        return html_of(self, lambda figure: self.plot(figure.add_subplot()))


class Check(PlanCheck):
    """Findings on a floorplan: :class:`fpnet.plan_check.PlanCheck` with a plot."""

    def __repr__(self) -> str:
        """Return the verdict and counts in one line."""
        rooms, doors = len(self.segmentation.rooms), len(self.segmentation.doors)
        said = 'accepted' if self.verdict.accepted else self.verdict.fitness.value
        return f'<Check {said}: {rooms} rooms, {doors} doors, {len(self.advice)} pieces of advice>'

    def plot(self, figure: Figure | None = None) -> Figure:
        """Draw the rooms and doors, and the rooms that look alike, side by side."""
        from fpnet.viz.plan_check import draw_plan_check, plan_check_inches

        figure = figure_of(figure, plan_check_inches(self.segmentation))
        draw_plan_check(figure, self.segmentation, self.similarity)
        return figure

    def _repr_html_(self) -> str:
        return html_of(self, self.plot)


class Match(MapMatch):
    """A robot map on a plan: :class:`fpnet_core.localizer.MapMatch` with a plot."""

    def __repr__(self) -> str:
        """Return status, probability and reason in one line."""
        return f'<Match {self.status.value} (p {self.probability:.2f}): {self.reason}>'

    def plot(self, figure: Figure | None = None) -> Figure:
        """Draw both maps, and the robot map's walls on the plan, side by side."""
        from fpnet.viz.match import SIZE_INCHES, draw_map_match

        figure = figure_of(figure, SIZE_INCHES)
        draw_map_match(figure, self)
        return figure

    def _repr_html_(self) -> str:
        return html_of(self, self.plot)
