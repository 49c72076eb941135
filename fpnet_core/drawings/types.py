# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Types of the drawing parser: file content, scale, options and result.

Pixels are x right, y down in the upright drawing; integers are pixel centres.
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

BUILDING_M = (2.5, 3_000.0)
"""Physical: shortest and longest drawing of a building [m]."""


class ScaleSource(StrEnum):
    """Source of a drawing's scale."""

    STATED = 'stated'  # a map_server YAML, --resolution
    LENGTH = 'length'  # --length X1,Y1,X2,Y2=METRES
    UNITS = 'units'  # units of the file, e.g. DXF or IFC
    SCALE_BAR = 'scale bar'
    DIMENSIONS = 'dimensions'  # dimension texts and their lines
    PAPER = 'paper'  # a printed ratio such as 1:100 and the paper size
    ROOM_TEXTS = 'room texts'  # areas and sizes printed in rooms
    ESTIMATED = 'estimated'  # doors, rooms and walls together
    UNKNOWN = 'unknown'


@dataclass(frozen=True)
class DrawingScale:
    """
    Scale of a drawing with its uncertainty.

    ``resolution_m`` is the edge of a pixel [m], ``low_m`` and ``high_m`` are its 90 % interval;
    ``why`` is the reason in a few words.
    """

    resolution_m: float
    low_m: float
    high_m: float
    source: ScaleSource
    why: str = ''

    @property
    def is_known(self) -> bool:
        """Whether the scale is stated by the user or the drawing."""
        return self.source not in (ScaleSource.ESTIMATED, ScaleSource.UNKNOWN)


@dataclass(frozen=True, eq=False)
class Strokes:
    """
    Line segments of a vector drawing, in pixels.

    ``ends (N, 2, 2)``, ``width (N,)``, ``colour (N, 3)`` uint8; ``path (N,)`` is the index of the
    path of a segment; ``is_curve (N,)`` is true for segments of arcs, circles and splines;
    ``layer (N,)`` indexes ``layers``.
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
    """A line of text; ``box`` is (left, top, right, bottom) [pixels]."""

    text: str
    box: tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Drawing:
    """
    Content of a drawing file before it is parsed.

    Parameters
    ----------
    pixels : (H, W, 3) uint8
        The upright drawing, white where transparent; large images are reduced. Of a vector
        drawing only presumed walls are rendered: no texts, curves or layers of furniture.
    name : name in messages
    format : ``png``, ``jpeg``, ``pdf``, ``svg``, ``dxf``, ``ifc``, ...
    strokes, labels : lines of a vector drawing; texts
    scale : scale stated by the format, e.g. units of a DXF; None if not stated
    A_pixel_image : (2, 3)
        From pixels of the file as stored (before it was turned upright) or, for vector formats,
        from its own units (y down for pages and SVG, y up for DXF and IFC) to pixels of the
        user's upright image of full size.
    paper_m : metres of paper per pixel; None if the format has no paper size
    door_px : widths of the door leaves in a vector drawing [pixels]
    notes : remarks from opening the file, one sentence each
    doubts : warnings that the file may not be a floorplan, one sentence each
    model : elements that the file states, in its own units and coordinates (the source of
        ``A_pixel_image``); None if the format has none
    full_size : (width, height) of the user's image if ``pixels`` is reduced
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
        """Whether ``pixels`` is smaller than the user's image."""
        return self.size != self.pixels.shape[1::-1]


@dataclass(frozen=True)
class ReadOptions:
    """
    User options for a drawing.

    ``resolution_m`` of a pixel; ``length`` as (x1, y1, x2, y2, metres) in pixels; ``crop`` as
    (left, top, right, bottom) in pixels; ``storey`` from 1, of several on one sheet; ``page``
    from 1, of a PDF or TIFF (or storey of an IFC); ``layers`` that hold walls, chosen
    automatically if empty.
    """

    resolution_m: float | None = None
    length: Length | None = None
    crop: tuple[int, int, int, int] | None = None
    storey: int | None = None
    page: int | None = None
    layers: tuple[str, ...] = ()


@dataclass(frozen=True)
class Doubtful:
    """Region of a parser warning: its kind ``what`` and its ``box`` in pixels."""

    what: str
    box: Box


@dataclass(frozen=True)
class RoomName:
    """Name of a room, and a point ``xy`` in it [m], in the map's frame."""

    name: str
    xy: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Reading:
    """
    Result of parsing a drawing.

    Parameters
    ----------
    grid : occupancy grid in frame ``plan``, in metres according to ``scale``
    scale : scale of the drawing's pixels; a cell may be larger than a pixel
    H_plan_image : (3, 3)
        From pixels of the user's own image, upright as in ``drawing.pixels``, to metres of
        ``grid``'s frame; a homography, affine unless perspective was removed.
    how : method of the parse in a few words
    storeys : boxes (left, top, right, bottom) [pixels] of the buildings on the sheet, in order
    notes : remarks for the user, one sentence each
    doubts : parser warnings, one sentence each; empty for a plausible parse
    doubtful : regions of these warnings on the drawing, for those that have one
    drawing : the parsed drawing
    model : stated elements of the storey in metres of ``grid``'s frame; None if not stated
    accepted : the user's reason to accept the parse despite warnings; empty if not accepted
    is_other : whether the drawing seems to show something other than a floorplan
    config : how rooms are segmented
    cut : segmentation of ``grid``, stated by the file or made by the parser; None if neither
    names : names of rooms that the record of a map holds (``room_names.py`` has all sources)
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
    names: tuple[RoomName, ...] = ()

    @cached_property
    def segmentation(self) -> Segmentation:
        """Rooms and doors of ``grid``, in its metres; computed once."""
        from fpnet_core.segmentation import segment_floorplan  # loads OpenCV

        return self.cut or segment_floorplan(self.grid, self.config)

    def segmented(self, config: SegmentationConfig) -> Segmentation:
        """Return the rooms and doors for a configuration; stated rooms do not depend on it."""
        is_stated = self.model is not None and self.model.states_rooms
        if is_stated or config == self.config:
            return self.segmentation
        return replace(self, config=config, cut=None).segmentation

    @property
    def estimate(self) -> ScaleEstimate | None:
        """Estimated true metres per metre of ``grid``; None if the scale is stated."""
        from fpnet_core.segmentation import (
            ScaleEstimate,
        )  # loads OpenCV, which this module avoids

        if self.scale.is_known:
            return None
        metres = self.scale.resolution_m
        return ScaleEstimate(1.0, self.scale.low_m / metres, self.scale.high_m / metres)

    def flipped(self) -> Reading:
        """Return the result flipped, for a drawing that is a mirror image."""
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
        names = tuple(_moved(each, mirror) for each in self.names)
        return replace(self, grid=grid, H_plan_image=H, how=how, model=model, cut=cut, names=names)

    @property
    def is_readable(self) -> bool:
        """Whether there are no parser warnings, or the user has accepted them."""
        return not self.doubts or bool(self.accepted)


def _moved(room: RoomName, A: Array) -> RoomName:
    """Return the name at a point mapped by an affine ``A (3, 3)``."""
    x, y, _ = (A @ (*room.xy, 1.0)).tolist()
    return replace(room, xy=(x, y))
