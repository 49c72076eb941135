# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""DXF export of artwork: layers, units, arcs, texts, dimensions and blocks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ezdxf import colors, options  # type: ignore[attr-defined]
from ezdxf.enums import TextEntityAlignment
from ezdxf.filemanagement import new
from ezdxf.layouts.base import BaseLayout
from ezdxf.layouts.blocklayout import BlockLayout
import numpy as np

from fpnet_core.geometry import Affine2D, Similarity2D
from fpnet_lab.sim.sheets.artwork import (
    Arcs,
    Area,
    Artwork,
    Colour,
    Dimension,
    Letters,
    Lines,
    Mark,
    Pen,
    Role,
    strokes_of,
)

UNITS: dict[str, tuple[int, float]] = {
    'm': (6, 1.0),
    'cm': (5, 100.0),
    'mm': (4, 1000.0),
    'unitless': (0, 1.0),
}
"""Given: units by name, with their code in ``$INSUNITS`` and their number per metre."""

_WEIGHTS = (0, 5, 9, 13, 15, 18, 20, 25, 30, 35, 40, 50, 53, 60, 70, 80, 90, 100, 120, 140, 200)
"""Given: line weights of DXF [0.01 mm]."""
_BLACKISH = 0.3  # chosen
_FULL_TURN_DEG = 360.0 - 1e-6  # numerical
_BLOCK_ROLES = {Role.DOOR, Role.FURNITURE}
_ALIGN = {
    'center': TextEntityAlignment.MIDDLE_CENTER,
    'left': TextEntityAlignment.MIDDLE_LEFT,
}


@dataclass(frozen=True)
class DxfStyle:
    """
    DXF conventions of an office.

    ``unit`` is a key of :data:`UNITS`; ``origin`` is the page's corner in model space [m].
    ``blocks`` writes doors and furniture as blocks, ``exploded`` writes dimensions as strokes and
    texts, and ``paper_space`` puts frame and title into paper space.
    """

    unit: str = 'mm'
    origin: tuple[float, float] = (0.0, 0.0)
    blocks: bool = False
    exploded: bool = False
    paper_space: bool = False

    @property
    def A_file_page(self) -> Affine2D:
        """Transform from page metres to drawing units, y up."""
        per_m = UNITS[self.unit][1]
        return Similarity2D.from_scale_yaw(per_m, 0.0, per_m * np.array(self.origin))


def draw_dxf_style(rng: np.random.Generator) -> DxfStyle:
    """Sample the DXF conventions of an office."""
    unit = str(rng.choice(list(UNITS), p=(0.3, 0.15, 0.45, 0.1)))
    is_far = rng.random() < 0.15  # national map grid
    origin = (3.5e6 + rng.uniform(0.0, 1e4), 5.4e6 + rng.uniform(0.0, 1e4)) if is_far else (0, 0)
    blocks, exploded, paper_space = (rng.random(3) < (0.5, 0.3, 0.3)).tolist()
    return DxfStyle(unit, (float(origin[0]), float(origin[1])), blocks, exploded, paper_space)


def write_dxf(
    artwork: Artwork, path: Path, layers: Mapping[Role, str], style: DxfStyle
) -> Affine2D:
    """
    Write the artwork to model space, without the paper's colour.

    Returns
    -------
    A_file_page : from page metres to drawing units, y up
    """
    with _without_dates():
        drawing = new('R2010', setup=True)
    drawing.header['$INSUNITS'] = UNITS[style.unit][0]
    drawing.header['$MEASUREMENT'] = 1
    for name in sorted({*layers.values(), '0'} - {'0'}):
        drawing.layers.add(name)
    paper_m = 1e3 / artwork.denominator
    A_paper_page = Similarity2D.from_scale_yaw(paper_m, 0.0, (0.0, 0.0))
    model = _Writer(drawing.modelspace(), style.A_file_page, layers, artwork.denominator)
    paper = _Writer(drawing.layout('Layout1'), A_paper_page, layers, artwork.denominator)
    for number, mark in enumerate(artwork.marks):
        writer = paper if style.paper_space and mark.role is Role.SHEET else model
        if style.blocks and mark.role in _BLOCK_ROLES:
            block = drawing.blocks.new(f'SYMBOL_{number}')
            writer.add_as_block(block, mark)
        else:
            writer.add(mark, style.exploded)
    with _without_dates():
        drawing.saveas(path)
    return style.A_file_page


@contextmanager
def _without_dates() -> Iterator[None]:
    """Disable dates and random identifiers, so that equal sheets give equal files."""
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


class _Writer:
    """Writer of marks to a layout, in the layout's units."""

    def __init__(
        self,
        layout: BaseLayout,
        A_file_page: Affine2D,
        layers: Mapping[Role, str],
        denominator: int,
    ) -> None:
        self._layout = layout
        self._A = A_file_page
        self._per_m = A_file_page.scale
        self._layers = layers
        self._denominator = denominator

    def add(self, mark: Mark, is_exploded: bool = True) -> None:
        """Add a mark; dimensions remain dimension entities unless ``is_exploded``."""
        if isinstance(mark, Dimension) and not is_exploded:
            self._add_dimension(mark)
            return
        for stroke in strokes_of(mark):
            if isinstance(stroke, Lines):
                self._add_lines(stroke)
            elif isinstance(stroke, Arcs):
                self._add_arcs(stroke)
            elif isinstance(stroke, Area):
                self._add_area(stroke)
            else:
                self._add_text(stroke)

    def add_as_block(self, block: BlockLayout, mark: Mark) -> None:
        """Add a mark as a block in metres, rotated by 90 degrees when it is inserted."""
        turn = Similarity2D.from_scale_yaw(1.0, -np.pi / 2.0, (0.0, 0.0))
        _Writer(block, turn, self._layers, self._denominator).add(mark)
        x, y = self._A.apply(np.zeros(2)).tolist()
        scale = {'xscale': self._per_m, 'yscale': self._per_m, 'rotation': 90.0}
        self._layout.add_blockref(block.name, (x, y), {'layer': self._layers[mark.role], **scale})

    def _add_lines(self, mark: Lines) -> None:
        attributes = self._attributes(mark.role, mark.pen)
        for line in mark.lines:
            points = self._A.apply(line).tolist()
            if len(points) == 2 and not mark.is_closed:
                self._layout.add_line(points[0], points[1], dxfattribs=attributes)
            else:
                self._layout.add_lwpolyline(points, close=mark.is_closed, dxfattribs=attributes)

    def _add_arcs(self, mark: Arcs) -> None:
        attributes = self._attributes(mark.role, mark.pen)
        turn = float(np.degrees(np.arctan2(self._A.linear[1, 0], self._A.linear[0, 0])))
        for centre, radius, span in zip(mark.centre, mark.radius, mark.span, strict=True):
            at, r = self._A.apply(centre).tolist(), float(radius) * self._per_m
            start, end = (np.degrees(span) + turn).tolist()
            if end - start > _FULL_TURN_DEG:
                self._layout.add_circle(at, r, dxfattribs=attributes)
            else:
                self._layout.add_arc(at, r, start, end, dxfattribs=attributes)

    def _add_area(self, mark: Area) -> None:
        """Add a solid hatch, and for walls also the outline."""
        attributes = {'layer': self._layers[mark.role], **_ink(mark.colour)}
        hatch = self._layout.add_hatch(dxfattribs=attributes)
        for number, ring in enumerate(mark.rings):
            flags = 1 if number == 0 else 16  # external, outermost
            hatch.paths.add_polyline_path(self._A.apply(ring).tolist(), flags=flags)
            if mark.role is Role.WALL:
                outline = self._A.apply(ring).tolist()
                self._layout.add_lwpolyline(outline, close=True, dxfattribs=attributes)

    def _add_text(self, mark: Letters) -> None:
        turn = float(np.arctan2(self._A.linear[1, 0], self._A.linear[0, 0]))
        text = self._layout.add_text(
            mark.text,
            height=mark.height_m * self._per_m,
            rotation=float(np.degrees(mark.angle_rad + turn)),
            dxfattribs={'layer': self._layers[mark.role], **_ink(mark.colour)},
        )
        at = self._A.apply(np.array(mark.xy)).tolist()
        text.set_placement(at, align=_ALIGN[mark.align])

    def _add_dimension(self, mark: Dimension) -> None:
        a, b, feet = (np.array(point) for point in (mark.a, mark.b, mark.feet))
        along = b - a
        ends = [self._A.apply(end + feet).tolist() for end in (a, b)]
        dimension = self._layout.add_linear_dim(
            base=self._A.apply(a).tolist(),
            p1=ends[0],
            p2=ends[1],
            angle=float(np.degrees(np.arctan2(along[1], along[0]))),
            text=mark.text or '<>',
            dimstyle='Standard',
            override={
                'dimtxt': mark.height_m * self._per_m,
                'dimtsz': 0.5 * mark.tick_m * self._per_m,
                'dimtad': 1,
                'dimexe': 0.5 * mark.tick_m * self._per_m,
                'dimexo': 0.0,
                'dimgap': 0.4 * mark.height_m * self._per_m,
            },
            dxfattribs={'layer': self._layers[mark.role]},
        )
        dimension.render()

    def _attributes(self, role: Role, pen: Pen) -> dict[str, object]:
        on_paper = 1e5 * pen.width_m / self._denominator
        weight = min(_WEIGHTS, key=lambda known: abs(known - on_paper))
        attributes: dict[str, object] = {
            'layer': self._layers[role],
            'lineweight': weight,
            **_ink(pen.colour),
        }
        if pen.dashes_m:
            attributes['linetype'] = 'DASHDOT'
            attributes['ltscale'] = pen.dashes_m[0] * self._per_m
        return attributes


def _ink(colour: Colour) -> dict[str, int]:
    """Return the colour's DXF attributes; near-black is colour 7, visible on any background."""
    if max(colour) < _BLACKISH:
        return {'color': 7}
    r, g, b = (round(255.0 * value) for value in colour)
    return {'true_color': int(colors.rgb2int((r, g, b)))}
