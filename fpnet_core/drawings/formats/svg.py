# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reader of SVG: shapes with styles, transforms and clip paths, and embedded images.

The file is parsed with a strict XML parser and sanitized: references to other files, scripts and
nested entities are removed or rejected. Only the sanitized text is given to a library.
"""

from __future__ import annotations

import base64
from collections.abc import Iterator
import io
from pathlib import Path
import re
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.formats.messages import detail_of
from fpnet_core.drawings.formats.pages import (
    CURVE_STEPS,
    EVERYWHERE,
    NO_PAINT,
    Array,
    Box,
    Colour,
    PageBuilder,
    PagePicture,
    Paint,
    Ring,
    VectorPage,
    darkened,
    narrowed,
    transformed,
)
from fpnet_core.drawings.formats.svg_cleaning import NUMBER, Clean, cleaned, parse, unpacked
from fpnet_core.drawings.lengths import INCH_M
from fpnet_core.drawings.types import Label, ReadOptions
from fpnet_core.errors import MapFormatError

PIXEL_M = INCH_M / 96.0
"""Given: length of a CSS pixel on paper [m]."""


_LENGTH = re.compile(r'\s*[-+.\deE]+\s*(?:px|mm|cm|in|pt|pc|%)?\s*')  # given
_PHYSICAL = ('mm', 'cm', 'in', 'pt', 'pc')
_MAX_PICTURE = 60_000_000  # numerical: largest embedded image [pixels]
_LETTER = 0.55  # width of letters over their size; chosen


def load_libraries() -> None:
    """Import the libraries of this reader before the process is restricted."""
    import PIL.PngImagePlugin  # noqa: F401
    import svgelements  # noqa: F401


def read_svg(path: Path, options: ReadOptions) -> VectorPage:
    """
    Return the page of an SVG or SVGZ file.

    Raises
    ------
    MapFormatError
        If it is no SVG, damaged, too large, or expands beyond the limits.
    """
    from svgelements import Matrix

    clean = cleaned(parse(unpacked(path), path.name), path.name, options.layers)
    for side in ('width', 'height'):
        if not _LENGTH.fullmatch(clean.root.get(side, '')):  # relative to a font or a viewport
            clean.root.attrib.pop(side, None)
    text = ElementTree.tostring(clean.root, encoding='unicode')
    shapes = _shapes(text, path.name)
    builder = PageBuilder(path.name)
    elements = list(shapes.elements())
    clips = _clips(elements, clean)
    for shape in elements:
        _add(builder, shape, clean, clips)
    if clean.dropped:
        builder.notes.append(f'left out: {", ".join(sorted(clean.dropped))}; nothing is fetched')
    page = builder.finish(
        box=_sheet(shapes),
        paper_m=PIXEL_M if _is_physical(clean.root) else None,
        A_page_file=_affine(Matrix(shapes.viewbox_transform or '')),
    )
    return darkened(page)


def _affine(matrix: Any) -> Array:
    m = matrix
    return np.array([[m.a, m.c, m.e], [m.b, m.d, m.f]], dtype=np.float64)


def _clips(elements: list[Any], clean: Clean) -> dict[str, tuple[Array, ...]]:
    """Return the rings of each clipping group, in the page's coordinates."""
    from svgelements import Shape

    found: dict[str, list[Array]] = {}
    for shape in elements:
        number = str(getattr(shape, 'values', {}).get(NUMBER, ''))
        if isinstance(shape, Shape) and number in clean.shapes_of_clips:
            rings = found.setdefault(clean.clips[number][0], [])
            rings.extend(r.points for r in _rings(shape) if np.isfinite(r.points).all())
    return {key: tuple(rings) for key, rings in found.items() if rings}


def _shapes(text: str, name: str) -> Any:
    from svgelements import SVG

    try:
        shapes = SVG.parse(io.StringIO(text), ppi=96.0, reify=True)
    except Exception as error:  # svgelements raises many types on damaged attributes
        raise MapFormatError(
            f'{name} is a damaged SVG ({detail_of(error)}); save it again'
        ) from None
    if not isinstance(shapes, SVG):
        raise MapFormatError(f'{name} is an SVG of another namespace; save it again')
    return shapes


def _sheet(shapes: Any) -> tuple[float, float, float, float] | None:
    width, height = shapes.width, shapes.height
    try:
        size = float(width), float(height)
    except (TypeError, ValueError):
        return None
    return (0.0, 0.0, *size) if min(size) > 0.0 and np.isfinite(size).all() else None


def _is_physical(root: ElementTree.Element) -> bool:
    return root.get('width', '').strip().endswith(_PHYSICAL)


def _add(
    builder: PageBuilder, shape: Any, clean: Clean, clips: dict[str, tuple[Array, ...]]
) -> None:
    from svgelements import Image, Shape, Text

    values = getattr(shape, 'values', {})
    number = str(values.get(NUMBER, ''))
    if number in clean.shapes_of_clips:
        return
    layer = clean.layers.get(number, '')
    if isinstance(shape, Image):
        _add_picture(builder, shape)
    elif isinstance(shape, Text):
        label = _label(shape)
        if label is not None:
            builder.labels.append(label)
    elif isinstance(shape, Shape) and values.get('visibility') != 'hidden':
        box, mask = _clip_of(
            builder, [clips[k] for k in clean.clips.get(number, ()) if k in clips]
        )
        paint = Paint(
            fill=_colour(shape.fill),
            stroke=_colour(shape.stroke),
            width=_number(shape.implicit_stroke_width),
            is_dashed=_is_dashed(values.get('stroke-dasharray')),
            is_even_odd=values.get('fill-rule') == 'evenodd',
            layer=layer,
            clip=box,
            mask=mask,
        )
        builder.add(_rings(shape), paint)


def _clip_of(builder: PageBuilder, clips: list[tuple[Array, ...]]) -> tuple[Box, int]:
    """Return the intersection of all clip paths' boxes, and the innermost mask that is no box."""
    box, mask = EVERYWHERE, -1
    for rings in clips:
        box = narrowed(box, np.concatenate(rings))
        if len(rings) > 1 or not _is_box(rings[0]):
            if not builder.masks or builder.masks[-1] is not rings:
                builder.masks.append(rings)
            mask = len(builder.masks) - 1
    return box, mask


def _is_box(points: Array) -> bool:
    """Return whether a ring is an axis-aligned rectangle."""
    x, y = (points - points[0]).T
    area = 0.5 * abs(float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))
    return bool(np.isclose(area, np.ptp(x) * np.ptp(y)))


def _add_picture(builder: PageBuilder, shape: Any) -> None:
    """Add an embedded image."""
    head, _, data = str(shape.url or '').partition(',')
    if not head.endswith('base64') or shape.width is None or shape.height is None:
        return
    try:
        pixels = _decoded(base64.b64decode(data, validate=False), builder.what)
    except (OSError, ValueError, SyntaxError) as error:
        raise MapFormatError(
            f'{builder.what} contains a damaged image ({detail_of(error)}); remove it'
        ) from None
    A_page_user = _affine(shape.transform)
    size = _number(shape.width), _number(shape.height)
    scale = np.array([size[0] / pixels.shape[1], size[1] / pixels.shape[0]])
    A = np.hstack([A_page_user[:, :2] * scale, transformed(
        np.array([_number(shape.x), _number(shape.y)]) + 0.5 * scale, A_page_user
    )[:, None]])  # fmt: skip
    if np.isfinite(A).all():
        builder.pictures.append(PagePicture(pixels, A))


def _decoded(data: bytes, name: str) -> NDArray[np.uint8]:
    """Return the pixels ``(H, W, 3)`` of an image on white."""
    from PIL import Image as PilImage

    PilImage.MAX_IMAGE_PIXELS = None  # the limit below replaces it in this process
    with PilImage.open(io.BytesIO(data), formats=('PNG', 'JPEG', 'GIF')) as image:
        if image.width * image.height > _MAX_PICTURE:
            raise MapFormatError(
                f'{name} contains an image of {image.width} x {image.height} pixels: expected at '
                f'most {_MAX_PICTURE // 1_000_000} million; scale it down'
            )
        paper = PilImage.new('RGBA', image.size, 'white')
        paper.alpha_composite(image.convert('RGBA'))
        return np.asarray(paper.convert('RGB'))


def _number(value: Any, default: float = 0.0) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        return default
    return number if np.isfinite(number) else default


def _colour(colour: Any) -> Colour:
    if colour is None or colour.value is None:
        return NO_PAINT
    return colour.red, colour.green, colour.blue, colour.alpha


def _is_dashed(dashes: Any) -> bool:
    return bool(dashes) and str(dashes).strip() not in ('none', '0')


def _rings(shape: Any) -> Iterator[Ring]:
    """
    Yield the rings of a shape, with curves as short segments.

    The conversion to a path applies the transforms of rotated or flipped rectangles and ellipses.
    """
    from svgelements import Close, Line, Move
    from svgelements import Path as ShapePath

    points: list[tuple[float, float]] = []
    curve: list[bool] = []
    for segment in abs(ShapePath(shape)):
        if isinstance(segment, Move):
            yield from _ring(points, curve, False)
            points, curve = [_xy(segment.end)], [False]
        elif isinstance(segment, Close):
            yield from _ring(points, curve, True)
            points, curve = ([_xy(segment.end)], [False]) if segment.end is not None else ([], [])
        elif isinstance(segment, Line):
            points.append(_xy(segment.end))
            curve.append(False)
        else:
            steps = np.linspace(0.0, 1.0, CURVE_STEPS + 1)[1:]
            if curve:
                curve[-1] = True
            points.extend(_xy(segment.point(t)) for t in steps)
            curve.extend([True] * (CURVE_STEPS - 1) + [False])
    yield from _ring(points, curve, False)


def _xy(point: Any) -> tuple[float, float]:
    return float(point.x), float(point.y)


def _ring(points: list[tuple[float, float]], curve: list[bool], is_closed: bool) -> Iterator[Ring]:
    if len(points) > 1:
        yield Ring(np.array(points), np.array(curve[: len(points)]), is_closed)


def _label(shape: Any) -> Label | None:
    """Return a label; its box is estimated from font size and number of letters."""
    text = ' '.join(str(shape.text or '').split())
    if not text:
        return None
    size = _number(shape.font_size, 16.0)
    width = _LETTER * size * len(text)
    start = {'middle': -0.5, 'end': -1.0}.get(str(shape.anchor), 0.0) * width
    x, y = _number(shape.x) + start, _number(shape.y)
    corners = np.array(
        [[x, y], [x + width, y], [x + width, y - 0.75 * size], [x, y - 0.75 * size]]
    )
    placed = transformed(corners, _affine(shape.transform))
    if not np.isfinite(placed).all():
        return None
    low, high = placed.min(axis=0), placed.max(axis=0)
    return Label(text, (float(low[0]), float(low[1]), float(high[0]), float(high[1])))
