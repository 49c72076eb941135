# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What a drawing is on its way to a map: what a file holds, what is known of its scale, the reading.

Pixels are (x right, y down) of the drawing as the user sees it, whole numbers are pixel centres.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import SegmentationConfig
from fpnet_core.types import GridMap, Segmentation

if TYPE_CHECKING:
    from fpnet_core.drawings.model import FloorplanModel
    from fpnet_core.segmentation import ScaleEstimate

Array = NDArray[np.float64]
Box = tuple[int, int, int, int]
Length = tuple[float, float, float, float, float]
Chances = NDArray[np.float32]


class ScaleSource(StrEnum):
    """Who says how long a metre is."""

    STATED = 'stated'  # a map_server YAML, --resolution
    LENGTH = 'length'  # --length X1,Y1,X2,Y2=METRES
    UNITS = 'units'  # DXF and IFC know their units
    SCALE_BAR = 'scale bar'
    DIMENSIONS = 'dimensions'  # dimension texts and their lines
    PAPER = 'paper'  # a stated 1:100 and the size of the paper
    ROOM_TEXTS = 'room texts'  # areas and sizes that are printed in rooms
    ESTIMATED = 'estimated'  # doors, rooms and walls together
    UNKNOWN = 'unknown'


@dataclass(frozen=True)
class DrawingScale:
    """
    What is known of a drawing's scale.

    ``resolution_m`` is the edge of a pixel [m], ``low_m`` and ``high_m`` hold the truth with 90 %
    probability; ``why`` says in a few words where it is from.
    """

    resolution_m: float
    low_m: float
    high_m: float
    source: ScaleSource
    why: str = ''

    @property
    def is_known(self) -> bool:
        """Tell whether somebody has stated it: nobody asks the doors, then."""
        return self.source not in (ScaleSource.ESTIMATED, ScaleSource.UNKNOWN)


@dataclass(frozen=True, eq=False)
class Strokes:
    """
    Straight pieces of a vector drawing's lines, in pixels.

    ``ends (N, 2, 2)``, ``width (N,)``, ``colour (N, 3)`` uint8, ``path (N,)`` numbers the path
    that a piece belongs to, ``is_curve (N,)`` tells pieces of arcs, circles and splines, ``layer
    (N,)`` indexes ``layers``.
    """

    ends: Array
    width: Array
    colour: NDArray[np.uint8]
    path: NDArray[np.int64]
    is_curve: NDArray[np.bool_]
    layer: NDArray[np.int64]
    layers: tuple[str, ...] = ('',)


@dataclass(frozen=True)
class Label:
    """A line of text of a vector drawing; ``box`` is (left, top, right, bottom) [pixels]."""

    text: str
    box: tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Drawing:
    """
    What a file holds, before anybody has read it as a plan.

    Parameters
    ----------
    pixels : (H, W, 3) uint8
        The drawing upright, on white where it is transparent; a large picture reduced. Of a
        vector drawing its walls only as far as they are known: without texts, curves and layers
        of furniture.
    name : what to call it in messages
    format : ``png``, ``jpeg``, ``pdf``, ``svg``, ``dxf``, ``ifc``, ...
    strokes, labels : of vector drawings
    scale : what the format itself says, as a DXF's units; None where it says nothing
    A_pixel_image : (2, 3)
        From pixels of the file as stored (before it was turned upright) or, of vector formats,
        its own units (y down for pages and SVG, y up for DXF and IFC) to pixels of the user's
        image, upright and of full size.
    paper_m : metres of paper per pixel, where the format has a paper size; None where not
    door_px : widths of the door leaves that a vector drawing shows, in pixels
    notes : what was noticed on opening, a sentence each
    doubts : reasons not to take the file for a floorplan, a sentence each
    model : the elements that the file itself holds, in its own units and coordinates, as
        ``A_pixel_image`` takes them; None where the format knows none
    full_size : (width, height) of the user's image where ``pixels`` are fewer
    """

    pixels: NDArray[np.uint8]
    name: str
    format: str
    strokes: Strokes | None = None
    labels: tuple[Label, ...] = ()
    scale: DrawingScale | None = None
    A_pixel_image: Array = field(default_factory=lambda: np.eye(2, 3))
    paper_m: float | None = None
    door_px: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    model: FloorplanModel | None = None
    full_size: tuple[int, int] | None = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels of the user's image."""
        height, width = self.pixels.shape[:2]
        return self.full_size or (width, height)

    @property
    def is_reduced(self) -> bool:
        """Tell whether ``pixels`` are fewer than those of the user's image."""
        return self.size != self.pixels.shape[1::-1]


@dataclass(frozen=True)
class ReadOptions:
    """
    What a user says about a drawing.

    ``resolution_m`` of a pixel; ``length`` as (x1, y1, x2, y2, metres) in pixels; ``crop`` as
    (left, top, right, bottom) in pixels; ``storey`` from 1, of several on one sheet; ``page``
    from 1, of a PDF or TIFF (or storey of an IFC); ``layers`` of a DXF that hold walls, empty to
    guess.
    """

    resolution_m: float | None = None
    length: Length | None = None
    crop: tuple[int, int, int, int] | None = None
    storey: int | None = None
    page: int | None = None
    layers: tuple[str, ...] = ()


@dataclass(frozen=True)
class Doubtful:
    """A place that may have been misread: ``what`` in a word, and its ``box`` in pixels."""

    what: str
    box: Box


@dataclass(frozen=True, eq=False)
class Reading:
    """
    A drawing read as a plan.

    Parameters
    ----------
    grid : in metres of ``scale.resolution_m``, frame ``plan``
    scale : what is known of it, for pixels of the drawing; a cell may be larger than a pixel
    H_plan_image : (3, 3)
        From the pixels of the user's own image, upright as in ``drawing.pixels``, to metres of
        ``grid``'s frame; a homography, which is affine unless a perspective was undone.
    how : the reading that won, in a few words: ``walls as learned from drawings``
    storeys : boxes (left, top, right, bottom) [pixels] of the buildings on the sheet, in order
    notes : what a user should know, a sentence each
    doubts : reasons not to believe the reading; empty for a plausible one
    doubtful : where these lie on the drawing, as far as they lie somewhere
    drawing : what was read
    model : the storey's elements, in metres of ``grid``'s frame; None where nobody tells them
    accepted : why its user takes it for a floorplan whatever speaks against it; empty if not
    is_other : whether it seems to show something else than a floorplan
    config : how its rooms are cut
    cut : rooms and doors of ``grid``, as the file states them or it was cut into to be read
    """

    grid: GridMap
    scale: DrawingScale
    H_plan_image: Array
    how: str
    drawing: Drawing
    storeys: tuple[tuple[int, int, int, int], ...] = ()
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    doubtful: tuple[Doubtful, ...] = ()
    model: FloorplanModel | None = None
    accepted: str = ''
    is_other: bool = False
    config: SegmentationConfig = field(default_factory=SegmentationConfig)
    cut: Segmentation | None = None

    @cached_property
    def segmentation(self) -> Segmentation:
        """Rooms and doors of ``grid``, in its metres; it is cut into them once."""
        from fpnet_core.segmentation import segment_floorplan  # loads OpenCV

        return self.cut or segment_floorplan(self.grid, self.config)

    def segmented(self, config: SegmentationConfig) -> Segmentation:
        """Return rooms and doors as a configuration asks for them, which mostly is its own."""
        is_stated = self.model is not None and self.model.states_rooms
        if is_stated or config == self.config:
            return self.segmentation
        return replace(self, config=config, cut=None).segmentation

    @property
    def estimate(self) -> ScaleEstimate | None:
        """True metres per metre of ``grid`` as estimated; None where somebody states them."""
        from fpnet_core.segmentation import (
            ScaleEstimate,
        )  # loads OpenCV, which these values do not

        if self.scale.is_known:
            return None
        metres = self.scale.resolution_m
        return ScaleEstimate(1.0, self.scale.low_m / metres, self.scale.high_m / metres)

    def flipped(self) -> Reading:
        """Return the reading of a drawing that is a mirror image, flipped."""
        from fpnet_core.segmentation.moved import mirrored_rooms  # loads OpenCV

        pose = self.grid.T_frame_grid.matrix
        width_m = self.grid.shape[1] * self.grid.resolution
        turned = np.array([[-1.0, 0.0, width_m], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        mirror = pose @ turned @ np.linalg.inv(pose)
        H = mirror @ self.H_plan_image
        model = self.model
        if model is not None:
            model = replace(model.moved(mirror[:2]), scale=model.scale, H_plan_image=H)
        how = f'{self.how}, flipped'
        grid, cut = self.grid.mirrored(), self.cut and mirrored_rooms(self.cut)
        return replace(self, grid=grid, H_plan_image=H, how=how, model=model, cut=cut)

    @property
    def is_readable(self) -> bool:
        """Tell whether nothing speaks against the reading, or its user accepts it."""
        return not self.doubts or bool(self.accepted)
