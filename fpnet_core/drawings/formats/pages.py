# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Vector page of lines, areas and texts in its own units, from PDF, SVG, DXF or IFC.

A path is painted as a whole, its area first and then its outline; it consists of rings, which
are point sequences. Later paths cover earlier ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.model import FloorplanModel
from fpnet_core.drawings.types import Label
from fpnet_core.errors import MapFormatError
from fpnet_core.geometry import scale_of

Array = NDArray[np.float64]
Colour = tuple[int, int, int, int]
"""Red, green, blue and opacity, 0 to 255."""
Box = tuple[float, float, float, float]
"""Lowest x, lowest y, highest x, highest y."""

MAX_POINTS = 3_000_000
"""Numerical: drawings of more points are rejected; an office floor has 10,000 to 500,000."""

MAX_NESTED = 12
"""Numerical: nesting limit of blocks and forms; it also ends recursive ones."""

PALE = 200
"""Chosen: a page on which nothing is darker was drawn for a dark background."""

NO_PAINT: Colour = (0, 0, 0, 0)  # given
BLACK: Colour = (0, 0, 0, 255)  # given
EVERYWHERE: Box = (-np.inf, -np.inf, np.inf, np.inf)
_FARTHEST = 1e12  # numerical: largest coordinate [units]; the comparison also rejects NaN
# Numerical: segments of a Bezier curve; those of a door's arc are short enough to detect it.
CURVE_STEPS = 12
_POWERS = np.linspace(0.0, 1.0, CURVE_STEPS + 1)[:, None]
# Numerical.
_BERNSTEIN = np.hstack([
    (1 - _POWERS) ** 3,
    3 * _POWERS * (1 - _POWERS) ** 2,
    3 * _POWERS**2 * (1 - _POWERS),
    _POWERS**3,
])  # fmt: skip


@dataclass(frozen=True, eq=False)
class Canvas:
    """Target image of a page: ``A_pixel_page (2, 3)``, ``shape`` (height, width) [pixels]."""

    A_pixel_page: Array
    shape: tuple[int, int]

    @property
    def pixels_per_unit(self) -> float:
        """Pixels per unit of the page."""
        return float(scale_of(self.A_pixel_page[:, :2]))


@dataclass(frozen=True, eq=False)
class PagePicture:
    """Image ``(H, W, 3)`` uint8 on a page; ``A_page_picture`` (2, 3) places it."""

    pixels: NDArray[np.uint8]
    A_page_picture: Array


Renderer = Callable[[NDArray[np.bool_], Canvas], NDArray[np.uint8]]
"""Renders the selected paths ``(P,)`` of a page on a canvas with the library of its format."""


class UnitKind(StrEnum):
    """Meaning and reliability of a page's units."""

    PAPER = 'paper'  # of a sheet; the scale of the building is not stated
    CLAIMED = 'claimed'  # of a building as stated by the file, often wrongly
    TRUE = 'true'


@dataclass(frozen=True)
class Ring:
    """
    A point sequence of a path.

    ``points (N, 2)``; ``is_curve`` (N,) or one for all: the segment from a point to the next one
    belongs to a curve; ``is_closed``: the last point is joined to the first.
    """

    points: Array
    is_curve: NDArray[np.bool_] | bool = False
    is_closed: bool = False


@dataclass(frozen=True)
class Paint:
    """
    Graphics state of a path.

    ``width`` of the outline in the page's units, 0 for a hairline. The path is clipped to ``clip``
    and to the page's mask of index ``mask``, -1 for none.
    """

    fill: Colour = NO_PAINT
    stroke: Colour = NO_PAINT
    width: float = 0.0
    is_dashed: bool = False
    is_even_odd: bool = False
    layer: str = ''
    clip: Box = EVERYWHERE
    mask: int = -1


@dataclass(frozen=True, eq=False)
class VectorPage:
    """
    Content of a page in its own units.

    ``points (V, 2)``, ``is_curve (V,)``; ``ring_start (R + 1,)`` indexes ``points``;
    ``is_closed (R,)``; ``path (R,)`` is the path of a ring. Of the paths: ``fill (P, 4)`` and
    ``stroke (P, 4)`` uint8, ``width (P,)``, ``is_dashed (P,)``, ``is_even_odd (P,)``, ``layer
    (P,)``, ``clip (P, 4)`` and ``mask (P,)``. ``masks`` are rings of points; ``labels`` have boxes
    in the page's units; ``box`` is the paper's, None if there is none; ``unit_m`` as stated by the
    format, with reliability ``unit_kind``; ``paper_m`` metres of paper per unit; ``A_page_file``
    from the file's own coordinates, if the page's differ; ``renderer`` paints the page better than
    its lines and areas do, None if those are complete; ``model`` holds the elements that the file
    states, in its own coordinates, None if it states none.
    """

    points: Array
    is_curve: NDArray[np.bool_]
    ring_start: NDArray[np.int64]
    is_closed: NDArray[np.bool_]
    path: NDArray[np.int64]
    fill: NDArray[np.uint8]
    stroke: NDArray[np.uint8]
    width: Array
    is_dashed: NDArray[np.bool_]
    is_even_odd: NDArray[np.bool_]
    layer: NDArray[np.int64]
    clip: Array
    mask: NDArray[np.int64]
    layers: tuple[str, ...]
    masks: tuple[tuple[Array, ...], ...] = ()
    labels: tuple[Label, ...] = ()
    pictures: tuple[PagePicture, ...] = ()
    box: Box | None = None
    is_y_up: bool = False
    unit_m: float | None = None
    unit_kind: UnitKind = UnitKind.PAPER
    paper_m: float | None = None
    A_page_file: Array = field(default_factory=lambda: np.eye(2, 3))
    notes: tuple[str, ...] = ()
    renderer: Renderer | None = None
    is_scan: bool = False
    model: FloorplanModel | None = None

    def with_renderer(self, renderer: Renderer, is_scan: bool = False) -> VectorPage:
        """Return the page with a renderer; ``is_scan``: the drawing is in the page's images."""
        return replace(self, renderer=renderer, is_scan=is_scan)


@dataclass
class PageBuilder:
    """Builder of a page from its paths; ``what`` names the drawing in messages."""

    what: str
    labels: list[Label] = field(default_factory=list)
    pictures: list[PagePicture] = field(default_factory=list)
    masks: list[tuple[Array, ...]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    _points: list[Array] = field(default_factory=list)
    _curve: list[NDArray[np.bool_]] = field(default_factory=list)
    _closed: list[bool] = field(default_factory=list)
    _path: list[int] = field(default_factory=list)
    _paints: list[Paint] = field(default_factory=list)
    _layers: dict[str, int] = field(default_factory=dict)
    _count: int = 0

    def add(self, rings: Iterable[Ring], paint: Paint) -> None:
        """
        Append a path; rings with fewer than two points or invalid coordinates are dropped.

        Raises
        ------
        MapFormatError
            If the page has more than ``MAX_POINTS``.
        """
        found = False
        for ring in rings:
            if len(ring.points) < 2 or not (np.abs(ring.points) < _FARTHEST).all():
                continue
            found = True
            self._points.append(np.asarray(ring.points, dtype=np.float64))
            self._curve.append(np.broadcast_to(ring.is_curve, len(ring.points)))
            self._closed.append(ring.is_closed)
            self._path.append(len(self._paints))
            self._count += len(ring.points)
        if self._count > MAX_POINTS:
            raise MapFormatError(
                f'{self.what} is too large: expected at most {MAX_POINTS // 1_000_000} million '
                'points of lines; export one storey without hatches and furniture'
            )
        if found:
            self._paints.append(paint)
            self._layers.setdefault(paint.layer, len(self._layers))

    @property
    def paths(self) -> int:
        """Number of paths."""
        return len(self._paints)

    def finish(
        self,
        box: Box | None = None,
        is_y_up: bool = False,
        unit_m: float | None = None,
        unit_kind: UnitKind = UnitKind.PAPER,
        paper_m: float | None = None,
        A_page_file: Array | None = None,
    ) -> VectorPage:
        """Return the page."""
        paints = self._paints
        lengths = np.array([len(points) for points in self._points], dtype=np.int64)
        return VectorPage(
            points=np.concatenate(self._points) if self._points else np.empty((0, 2)),
            is_curve=np.concatenate(self._curve) if self._curve else np.empty(0, np.bool_),
            ring_start=np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64),
            is_closed=np.array(self._closed, dtype=np.bool_),
            path=np.array(self._path, dtype=np.int64),
            fill=np.array([p.fill for p in paints], dtype=np.uint8).reshape(-1, 4),
            stroke=np.array([p.stroke for p in paints], dtype=np.uint8).reshape(-1, 4),
            width=np.array([p.width for p in paints], dtype=np.float64),
            is_dashed=np.array([p.is_dashed for p in paints], dtype=np.bool_),
            is_even_odd=np.array([p.is_even_odd for p in paints], dtype=np.bool_),
            layer=np.array([self._layers[p.layer] for p in paints], dtype=np.int64),
            clip=np.array([p.clip for p in paints], dtype=np.float64).reshape(-1, 4),
            layers=tuple(self._layers) or ('',),
            mask=np.array([p.mask for p in paints], dtype=np.int64),
            masks=tuple(self.masks),
            labels=tuple(self.labels),
            pictures=tuple(self.pictures),
            box=box,
            is_y_up=is_y_up,
            unit_m=unit_m,
            unit_kind=unit_kind,
            paper_m=paper_m,
            A_page_file=np.eye(2, 3) if A_page_file is None else A_page_file,
            notes=tuple(self.notes),
        )


def darkened(page: VectorPage) -> VectorPage:
    """
    Return the page with inverted colours if nothing on it is darker than ``PALE``.

    A page without a background and with light lines only was drawn for a dark background.
    """
    shown = [colour[colour[:, 3] > 0, :3] for colour in (page.fill, page.stroke)]
    if page.pictures or not sum(map(len, shown)) or np.concatenate(shown).min() <= PALE:
        return page
    fill, stroke = page.fill.copy(), page.stroke.copy()
    fill[:, :3], stroke[:, :3] = 255 - fill[:, :3], 255 - stroke[:, :3]
    return replace(page, fill=fill, stroke=stroke)


def bezier(controls: Sequence[Sequence[float]] | Array) -> Array:
    """Return points ``(N, 2)`` of a cubic Bezier curve of ``controls (4, 2)``."""
    points: Array = _BERNSTEIN @ np.asarray(controls, dtype=np.float64)
    return points


def narrowed(box: Box, points: Array) -> Box:
    """Return a box clipped to the bounding box of a clip path's ``points (N, 2)``."""
    low, high = np.maximum(box[:2], points.min(axis=0)), np.minimum(box[2:], points.max(axis=0))
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def transformed(points: Array, A: Array) -> Array:
    """Return ``points (..., 2)`` transformed by the affine ``A (2, 3)``."""
    moved: Array = points @ A[:, :2].T + A[:, 2]
    return moved


def composed(A: Array, B: Array) -> Array:
    """Return the affine (2, 3) that applies ``B`` and then ``A``."""
    result: Array = A[:, :2] @ B
    result[:, 2] += A[:, 2]
    return result


@dataclass(frozen=True, eq=False)
class OutlinePieces:
    """
    Line segments of a page's outlines.

    ``ends (N, 2, 2)``; ``path (N,)``, ``ring (N,)``; ``is_curve (N,)``; consecutive segments of
    the same ring are connected.
    """

    ends: Array
    path: NDArray[np.int64]
    ring: NDArray[np.int64]
    is_curve: NDArray[np.bool_]

    @property
    def length(self) -> Array:
        """Lengths ``(N,)`` in the page's units."""
        length: Array = np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T)
        return length

    def __getitem__(self, chosen: NDArray[np.bool_]) -> OutlinePieces:
        """Return the ``chosen (N,)`` segments."""
        return OutlinePieces(
            self.ends[chosen], self.path[chosen], self.ring[chosen], self.is_curve[chosen]
        )


def outline_pieces(page: VectorPage) -> OutlinePieces:
    """Return the segments of all paths in order, painted or not, without those of no length."""
    count = len(page.points)
    ring = np.repeat(np.arange(len(page.path)), np.diff(page.ring_start))
    following = np.arange(1, count + 1)
    last = page.ring_start[1:] - 1
    following[last] = np.where(page.is_closed, page.ring_start[:-1], last)
    ends = np.stack([page.points, page.points[following]], axis=1) if count else _NO_ENDS
    keep = (ends[:, 0] != ends[:, 1]).any(axis=1)
    return OutlinePieces(ends[keep], page.path[ring][keep], ring[keep], page.is_curve[keep])


_NO_ENDS = np.empty((0, 2, 2))
