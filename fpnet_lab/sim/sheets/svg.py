# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""SVG export of artwork, with groups as layers, and native texts, arcs and dashes."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from fpnet_core.geometry import Affine2D
from fpnet_lab.sim.sheets.artwork import (
    Arcs,
    Area,
    Array,
    Artwork,
    Colour,
    Lines,
    Pen,
    Role,
    Stroke,
)
from fpnet_lab.sim.sheets.painting import CAPITAL_SHARE

_NAMESPACE = 'http://www.w3.org/2000/svg'
_INKSCAPE = 'http://www.inkscape.org/namespaces/inkscape'
_ANCHORS = {'center': 'middle', 'left': 'start'}
_FULL_TURN = 2.0 * np.pi - 1e-6  # numerical


def write_svg(
    artwork: Artwork, path: Path, layers: Mapping[Role, str], units_per_mm: float = 1.0
) -> Affine2D:
    """
    Write the artwork with paper size in mm and ``units_per_mm`` user units per mm.

    Returns
    -------
    A_file_page : from page metres to user units, y down
    """
    per_m = units_per_mm * 1e3 / artwork.denominator
    width, height = (side * per_m for side in artwork.size_m)
    A_file_page = Affine2D(np.diag([per_m, -per_m]), np.array([0.0, height]))
    ET.register_namespace('inkscape', _INKSCAPE)
    root = ET.Element(
        'svg',
        {
            'xmlns': _NAMESPACE,
            'version': '1.1',
            'width': f'{artwork.size_mm[0]:.3f}mm',
            'height': f'{artwork.size_mm[1]:.3f}mm',
            'viewBox': f'0 0 {width:.3f} {height:.3f}',
        },
    )
    if artwork.paper is not None:
        box = {'width': f'{width:.3f}', 'height': f'{height:.3f}', 'fill': _hex(artwork.paper)}
        ET.SubElement(root, 'rect', box)
    writer = _Writer(A_file_page, per_m)
    for number, (role, strokes) in enumerate(groupby(artwork.strokes, lambda mark: mark.role)):
        group = ET.SubElement(
            root,
            'g',
            {
                'id': f'layer{number}',
                f'{{{_INKSCAPE}}}groupmode': 'layer',
                f'{{{_INKSCAPE}}}label': layers[role],
                'class': layers[role],
            },
        )
        for stroke in strokes:
            writer.add(group, stroke)
    ET.indent(root, ' ')
    ET.ElementTree(root).write(path, encoding='utf-8', xml_declaration=True)
    return A_file_page


class _Writer:
    """Writer of marks as SVG elements, in user units."""

    def __init__(self, A_file_page: Affine2D, per_m: float) -> None:
        self._A = A_file_page
        self._per_m = per_m

    def add(self, group: ET.Element, mark: Stroke) -> None:
        if isinstance(mark, Lines):
            tag = 'polygon' if mark.is_closed else 'polyline'
            for line in mark.lines:
                ET.SubElement(group, tag, {'points': self._points(line), **self._pen(mark.pen)})
        elif isinstance(mark, Area):
            outline = ' '.join(f'M {self._points(ring)} Z' for ring in mark.rings)
            style = {'d': outline, 'fill': _hex(mark.colour), 'fill-rule': 'evenodd'}
            ET.SubElement(group, 'path', style)
        elif isinstance(mark, Arcs):
            self._add_arcs(group, mark)
        else:
            x, y = self._A.apply(np.array(mark.xy)).tolist()
            height = mark.height_m * self._per_m
            text = ET.SubElement(
                group,
                'text',
                {
                    'x': f'{x:.3f}',
                    'y': f'{y + height / 2.0:.3f}',
                    'font-size': f'{height / CAPITAL_SHARE:.3f}',
                    'font-family': f"'{mark.font}', sans-serif",
                    'font-weight': 'bold' if mark.is_bold else 'normal',
                    'text-anchor': _ANCHORS[mark.align],
                    'fill': _hex(mark.colour),
                },
            )
            if mark.angle_rad:
                angle = -np.degrees(mark.angle_rad)
                text.set('transform', f'rotate({angle:.3f} {x:.3f} {y:.3f})')
            text.text = mark.text

    def _add_arcs(self, group: ET.Element, arcs: Arcs) -> None:
        for centre, radius, span in zip(arcs.centre, arcs.radius, arcs.span, strict=True):
            r = radius * self._per_m
            style = self._pen(arcs.pen)
            if span[1] - span[0] > _FULL_TURN:
                x, y = self._A.apply(centre).tolist()
                at = {'cx': f'{x:.3f}', 'cy': f'{y:.3f}', 'r': f'{r:.3f}'}
                ET.SubElement(group, 'circle', {**at, **style})
                continue
            ends = centre + radius * np.stack([np.cos(span), np.sin(span)], axis=1)
            start, end = (self._points(point[None]) for point in ends)
            is_large = int(span[1] - span[0] > np.pi)
            # Counter-clockwise with y up is negative with y down: sweep flag 0.
            outline = f'M {start} A {r:.3f} {r:.3f} 0 {is_large} 0 {end}'
            ET.SubElement(group, 'path', {'d': outline, **style})

    def _points(self, xy: Array) -> str:
        return ' '.join(f'{x:.3f},{y:.3f}' for x, y in self._A.apply(xy).tolist())

    def _pen(self, pen: Pen) -> dict[str, str]:
        style = {
            'fill': 'none',
            'stroke': _hex(pen.colour),
            'stroke-width': f'{pen.width_m * self._per_m:.4f}',
        }
        if pen.dashes_m:
            lengths = ' '.join(f'{length * self._per_m:.3f}' for length in pen.dashes_m)
            style['stroke-dasharray'] = lengths
        return style


def _hex(colour: Colour) -> str:
    return '#{:02x}{:02x}{:02x}'.format(*(round(255.0 * value) for value in colour))
