# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A small building as a drawing in every vector format, with what is where.

Outside 10.4 m x 6.4 m; a wall from left to right at x = 6.0 to 6.2 with a door at y = 2 to 2.9,
whose leaf is drawn open, with the arc that it sweeps. Building metres, y up, origin at the lower
left; the walls turn by no multiple of 90 degrees where ``turn`` says so.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

WALLS = (  # left, low, right, high
    (0.0, 0.0, 10.4, 0.3), (0.0, 6.1, 10.4, 6.4), (0.0, 0.0, 0.3, 6.4), (10.1, 0.0, 10.4, 6.4),
    (6.0, 0.3, 6.2, 2.0), (6.0, 2.9, 6.2, 6.1),
)  # fmt: skip
DOOR = ((6.0, 2.0), 0.9)  # hinge, width; opens to the left, from pointing up
ON_WALLS = ((3.0, 0.15), (8.0, 6.25), (0.15, 3.0), (10.25, 3.0), (6.1, 1.0), (6.1, 4.5))
IN_ROOMS = ((3.0, 3.0), (8.0, 3.0), (6.1, 2.45), (1.0, 5.5), (9.5, 1.0))
LEAF = (5.55, 2.0)  # the middle of the open leaf
ON_ARC = (6.0 - 0.9 * np.sqrt(0.5), 2.0 + 0.9 * np.sqrt(0.5))
DASHED = ((1.0, 5.0), (5.5, 5.0))
FURNITURE = (7.0, 4.0, 8.5, 5.0)
TEXT = (3.0, 1.5)


@dataclass(frozen=True)
class Plan:
    """How the building is drawn: units per metre, turn [rad], origin and layers' names."""

    per_m: float = 1.0
    turn: float = 0.0
    origin: tuple[float, float] = (0.0, 0.0)
    layers: dict[str, str] = field(
        default_factory=lambda: {
            'wall': 'A-WALL', 'door': 'A-DOOR', 'furniture': 'A-FURN', 'text': 'A-ANNO-TEXT',
        }
    )  # fmt: skip

    def place(self, points):
        """Return building points ``(N, 2)`` in the file's units."""
        c, s = np.cos(self.turn), np.sin(self.turn)
        turned = np.asarray(points, float) @ np.array([[c, s], [-s, c]])
        return self.per_m * turned + self.origin


def corners(box):
    left, low, right, high = box
    return [(left, low), (right, low), (right, high), (left, high)]


def arc_points(count=13):
    (x, y), width = DOOR
    angle = np.linspace(np.pi / 2.0, np.pi, count)
    return np.column_stack([x + width * np.cos(angle), y + width * np.sin(angle)])


def write_dxf(path: Path, plan: Plan = Plan(), units: int = 6, change=None) -> Path:
    import ezdxf

    document = ezdxf.new('R2010')
    document.header['$INSUNITS'] = units
    document.linetypes.add('DASHED', [1.0, 0.5, -0.5])
    for name in plan.layers.values():
        document.layers.add(name)
    space = document.modelspace()
    for box in WALLS:
        space.add_lwpolyline(
            plan.place(corners(box)), close=True, dxfattribs={'layer': plan.layers['wall']}
        )
    _dxf_doors(document, space, plan)
    space.add_lwpolyline(
        plan.place(corners(FURNITURE)), close=True, dxfattribs={'layer': plan.layers['furniture']}
    )
    space.add_line(
        *plan.place(DASHED), dxfattribs={'layer': plan.layers['wall'], 'linetype': 'DASHED'}
    )
    space.add_text(
        'Office', height=0.3 * plan.per_m,
        dxfattribs={'insert': plan.place([TEXT])[0], 'layer': plan.layers['text']},
    )  # fmt: skip
    if change is not None:
        change(document, space)
    document.saveas(path)
    return path


def _dxf_doors(document, space, plan: Plan) -> None:
    """Add the door as a block, as CAD programs do, and two more in the outer walls."""
    block = document.blocks.new('LEAF')
    block.add_line((0, 0), (-1, 0))
    block.add_arc((0, 0), 1.0, 90.0, 180.0)
    for hinge in (DOOR[0], (3.0, 6.1), (9.0, 6.1)):
        space.add_blockref(
            'LEAF',
            plan.place([hinge])[0],
            dxfattribs={
                'layer': plan.layers['door'],
                'xscale': DOOR[1] * plan.per_m,
                'yscale': DOOR[1] * plan.per_m,
                'rotation': np.degrees(plan.turn),
            },
        )


def write_svg(path: Path, plan: Plan = Plan(20.0), body: str = '', head: str = '') -> Path:
    """Write the building with y down: a building point is at (x, 6.4 - y) times the scale."""
    polygons = ''.join(f'<polygon points="{_svg_points(corners(box), plan)}"/>' for box in WALLS)
    arc = f'<polyline points="{_svg_points(arc_points(), plan)}"/>'
    leaf = (
        f'<polyline points="{_svg_points([DOOR[0], (DOOR[0][0] - DOOR[1], DOOR[0][1])], plan)}"/>'
    )
    dashed = f'<polyline stroke-dasharray="4 2" points="{_svg_points(DASHED, plan)}"/>'
    x, y = _svg_place([TEXT], plan)[0]
    text = f'<text x="{x}" y="{y}" font-size="{0.3 * plan.per_m}">Office</text>'
    width, height = 12.0 * plan.per_m, 8.0 * plan.per_m
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        f'width="{width}" height="{height}" viewBox="0 0 {width} {height}" {head}>'
        f'<g fill="black">{polygons}</g>'
        f'<g fill="none" stroke="black" stroke-width="{0.02 * plan.per_m}">{arc}{leaf}{dashed}</g>'
        f'{text}{body}</svg>',
        encoding='utf-8',
    )
    return path


def _svg_place(points, plan: Plan):
    placed = np.asarray(points, float).copy()
    placed[:, 1] = 7.0 - placed[:, 1]
    placed[:, 0] += 0.5
    return placed * plan.per_m


def _svg_points(points, plan: Plan) -> str:
    return ' '.join(f'{x:.5f},{y:.5f}' for x, y in _svg_place(points, plan))


def write_pdf(path: Path, ratio: float = 50.0, texts=(), pages: int = 1, lines=()) -> Path:
    """Write the building at 1:``ratio`` on A4; the plan is on the last of several pages."""
    from matplotlib.backends.backend_pdf import PdfPages
    from matplotlib.figure import Figure

    with PdfPages(path) as pdf:
        for number in range(pages):
            figure = Figure((11.69, 8.27))
            if number + 1 < pages:
                figure.text(0.1, 0.9, 'A page of words only')
            else:
                _pdf_plan(figure, ratio, texts, lines)
            pdf.savefig(figure)
    return path


def pdf_points(points, ratio: float = 50.0):
    """Return building points in PDF points from the top left of the page."""
    paper = np.asarray(points, float) / ratio / 0.0254 * 72.0 + 72.0
    paper[:, 1] = 8.27 * 72.0 - paper[:, 1]
    return paper


def _pdf_plan(figure, ratio, texts, lines) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Polygon

    size = np.array([11.69, 8.27])

    def place(points):
        return (np.asarray(points, float) / ratio / 0.0254 + 1.0) / size

    def add(points, **style):
        figure.add_artist(Line2D(*place(points).T, color='black', linewidth=0.5, **style))

    for box in WALLS:
        figure.add_artist(Polygon(place(corners(box)), facecolor='black', edgecolor='none'))
    for shift in ((0.0, 0.0), (-3.0, 3.2), (3.0, 3.2)):
        hinge = np.add(DOOR[0], shift)
        add(arc_points() + shift)
        add([hinge, hinge - (DOOR[1], 0.0)])
    add(DASHED, linestyle='--')
    for line in lines:
        add(line)
    for x, y, text in ((*TEXT, 'Office'), *texts):
        figure.text(*place([(x, y)])[0], text, fontsize=7, ha='center', va='center')


def levels(drawing, points):
    """Return the brightness 0 to 255 of a drawing at points ``(N, 2)`` of the file."""
    A = drawing.A_pixel_image
    x, y = np.rint(np.asarray(points, float) @ A[:, :2].T + A[:, 2]).astype(int).T
    return drawing.pixels[y, x].mean(axis=1)
