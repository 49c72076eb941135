# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
SVG: shapes with their styles, transforms and clip paths, and the pictures within the file.

The file is parsed once with a strict XML parser and cleaned: nothing that refers to another file
stays, no scripts, no entities within entities. Only the cleaned text is given to a library.
"""

from __future__ import annotations

import base64
from collections.abc import Iterator
from dataclasses import dataclass, field
import io
from pathlib import Path
import re
from typing import Any
from xml.etree import ElementTree
from xml.parsers import expat
import zlib

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.layers import Role, layer_role
from fpnet_core.drawings.messages import detail_of
from fpnet_core.drawings.pages import (
    EVERYWHERE,
    NO_PAINT,
    Array,
    Box,
    Colour,
    PageBuilder,
    Paint,
    Picture,
    Ring,
    VectorPage,
    transformed,
)
from fpnet_core.drawings.types import Label, ReadOptions
from fpnet_core.errors import MapFormatError

PIXEL_M = 0.0254 / 96.0
"""Length of CSS's pixel on paper [m]."""

MAX_BYTES = 64 * 2**20
"""Of an SVG after unpacking."""

_MAX_ELEMENTS = 300_000
_MAX_PATHS = 8 * 2**20  # letters of path data, half a million pieces
_MAX_DEPTH = 900  # groups in groups; converters from PDF nest one per clip path
_MAX_ENTITY = 1_000  # letters of an entity; drawing programs keep their namespaces in such
_CHUNK = 2**20
_NUMBER = 'data-fpnet'  # attribute that numbers the elements
_DROPPED = frozenset({
    'script', 'foreignObject', 'animate', 'animateTransform', 'animateMotion', 'animateColor',
    'set', 'handler', 'listener', 'iframe', 'audio', 'video', 'a11y', 'metadata', 'namedview',
})  # fmt: skip
_PHYSICAL = ('mm', 'cm', 'in', 'pt', 'pc')
_PICTURES = ('data:image/png', 'data:image/jpeg', 'data:image/jpg', 'data:image/gif')
_MAX_CLIPS = 12  # clip paths around an element that count, the innermost ones
_MAX_CLIP_SHAPES = 50
_CLIP = re.compile(r'(?:^|clip-path:\s*)url\(\s*["\']?#([^"\')\s]+)')
_CLIP_SHAPES = frozenset({'path', 'rect', 'circle', 'ellipse', 'polygon', 'polyline'})
_GEOMETRY = frozenset({
    'd', 'x', 'y', 'width', 'height', 'cx', 'cy', 'r', 'rx', 'ry', 'points', 'transform',
})  # fmt: skip
_MAX_PICTURE = 60_000_000  # pixels of a picture within the file
_LETTER = 0.55  # of the letters' size, their width
_CURVE_STEPS = 12
_SVG = 'http://www.w3.org/2000/svg'


@dataclass
class _Clean:
    """
    A cleaned tree: layers of its numbered elements, and what was left out.

    ``clips`` are the numbers of the groups that clip an element: copies of clip paths in the place
    where they apply, so that the library that places shapes places them, too.
    """

    root: ElementTree.Element
    by_id: dict[str, ElementTree.Element] = field(default_factory=dict)
    layers: dict[str, str] = field(default_factory=dict)
    clips: dict[str, tuple[str, ...]] = field(default_factory=dict)
    shapes_of_clips: set[str] = field(default_factory=set)
    count: int = 0
    dropped: set[str] = field(default_factory=set)


def load_libraries() -> None:
    """Import what reading takes, before the process may do no more than read."""
    import PIL.PngImagePlugin  # noqa: F401
    import svgelements  # noqa: F401


def read_svg(path: Path, options: ReadOptions) -> VectorPage:
    """
    Return the drawing of an SVG or SVGZ file.

    Raises
    ------
    MapFormatError
        If it is no SVG, damaged, too large, or grows when it is read.
    """
    from svgelements import Matrix

    clean = _cleaned(_parse(_unpacked(path), path.name), path.name)
    text = ElementTree.tostring(clean.root, encoding='unicode')
    shapes = _shapes(text, path.name)
    builder = PageBuilder(path.name)
    elements = list(shapes.elements())
    clips = _clips(elements, clean)
    for shape in elements:
        _add(builder, shape, clean, clips)
    if clean.dropped:
        builder.notes.append(f'left out: {", ".join(sorted(clean.dropped))}; nothing is fetched')
    return builder.finish(
        box=_sheet(shapes),
        paper_m=PIXEL_M if _is_physical(clean.root) else None,
        A_page_file=_affine(Matrix(shapes.viewbox_transform or '')),
    )


def _affine(matrix: Any) -> Array:
    m = matrix
    return np.array([[m.a, m.c, m.e], [m.b, m.d, m.f]], dtype=np.float64)


def _unpacked(path: Path) -> bytes:
    data = path.read_bytes() if path.stat().st_size <= MAX_BYTES else b''
    if data[:2] == b'\x1f\x8b':
        try:
            data = zlib.decompressobj(wbits=31).decompress(data, MAX_BYTES + 1)
        except zlib.error:
            raise MapFormatError(f'{path.name} is a damaged SVGZ file; save it again') from None
    if not 0 < len(data) <= MAX_BYTES:
        raise MapFormatError(
            f'{path.name} is too large: expected at most {MAX_BYTES // 2**20} MB of SVG; '
            'remove pictures and hatches'
        )
    return data


def _parse(data: bytes, name: str) -> ElementTree.Element:
    """Return the tree of an XML text; entities that hold entities or files are refused."""
    builder = ElementTree.TreeBuilder()
    parser = expat.ParserCreate(namespace_separator='}')
    depth, count = 0, 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth, count
        depth, count = depth + 1, count + 1
        if depth > _MAX_DEPTH or count > _MAX_ELEMENTS:
            raise MapFormatError(
                f'{name} is too large: expected at most {_MAX_ELEMENTS:,} elements, nested at '
                f'most {_MAX_DEPTH} deep; simplify it'
            )
        builder.start(_tag(tag), {_tag(key): value for key, value in attributes.items()})

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(_tag(tag))

    def entity(key: str, is_parameter: int, value: str | None, *_: str | None) -> None:
        if is_parameter or value is None or '&' in value or len(value) > _MAX_ENTITY:
            raise MapFormatError(
                f'{name} defines the entity {key[:40]!a}, which grows or refers to another file; '
                'save it as plain SVG'
            )

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = builder.data
    parser.EntityDeclHandler = entity
    parser.buffer_text = True
    try:
        parser.Parse(data, True)
        return builder.close()
    except (expat.ExpatError, AssertionError, ValueError, LookupError) as error:
        raise MapFormatError(
            f'{name} is a damaged SVG ({detail_of(error)}); save it again'
        ) from None


def _tag(name: str) -> str:
    return '{' + name if '}' in name else name


def _local(element: ElementTree.Element) -> str:
    return str(element.tag).rpartition('}')[2]


def _cleaned(root: ElementTree.Element, name: str) -> _Clean:
    if _local(root) != 'svg':
        raise MapFormatError(f'{name} is XML, but no SVG: its root is {_local(root)[:40]!a}')
    clean = _Clean(root)
    clean.by_id = {element.get('id', ''): element for element in root.iter()}
    _clean_element(clean, root, '', ())
    _refuse_growth(root, name)
    return clean


def _clean_element(
    clean: _Clean, element: ElementTree.Element, layer: str, clips: tuple[str, ...]
) -> None:
    number = _numbered(clean, element)
    layer = clean.layers[number] = _layer(element, layer)
    clean.clips[number] = clips
    for key in list(element.attrib):
        value = element.attrib[key]
        local = key.rpartition('}')[2].lower()
        if local.startswith('on') or (local == 'href' and not _is_inside(value)):
            clean.dropped.add('references to other files' if local == 'href' else 'scripts')
            del element.attrib[key]
        elif 'url(' in value and not _refers_inside(value):
            clean.dropped.add('references to other files')
            del element.attrib[key]
    for child in list(element):
        kind = _local(child)
        if kind in _DROPPED or _is_hidden(child):
            element.remove(child)
        elif kind == 'style' and (
            '@import' in (child.text or '') or not _refers_inside(child.text)
        ):
            clean.dropped.add('references to other files')
            element.remove(child)
        else:
            own = _clip_copy(clean, element, child)
            _clean_element(clean, child, layer, (*clips, own)[-_MAX_CLIPS:] if own else clips)


def _numbered(clean: _Clean, element: ElementTree.Element) -> str:
    clean.count += 1
    element.set(_NUMBER, str(clean.count))
    return str(clean.count)


def _clip_copy(clean: _Clean, parent: ElementTree.Element, element: ElementTree.Element) -> str:
    """Put a copy of an element's clip path beside it and return its number; empty if none."""
    match = _CLIP.search(element.get('clip-path') or element.get('style') or '')
    source = clean.by_id.get(match.group(1)) if match else None
    if source is None or _local(source) != 'clipPath' or len(source) > _MAX_CLIP_SHAPES:
        return ''
    group = ElementTree.Element(f'{{{_SVG}}}g', {
        key: element.attrib[key] for key in ('transform',) if key in element.attrib
    })  # fmt: skip
    number = _numbered(clean, group)
    for child in source:
        if _local(child) in _CLIP_SHAPES:
            copied = ElementTree.SubElement(group, child.tag, {
                key: value for key, value in child.attrib.items() if key in _GEOMETRY
            })  # fmt: skip
            clean.shapes_of_clips.add(_numbered(clean, copied))
            clean.clips[copied.get(_NUMBER, '')] = (number,)
    parent.append(group)
    return number


def _clips(elements: list[Any], clean: _Clean) -> dict[str, tuple[Array, ...]]:
    """Return the rings, in the page's coordinates, of each group that clips."""
    from svgelements import Shape

    found: dict[str, list[Array]] = {}
    for shape in elements:
        number = str(getattr(shape, 'values', {}).get(_NUMBER, ''))
        if isinstance(shape, Shape) and number in clean.shapes_of_clips:
            rings = found.setdefault(clean.clips[number][0], [])
            rings.extend(r.points for r in _rings(shape) if np.isfinite(r.points).all())
    return {key: tuple(rings) for key, rings in found.items() if rings}


def _is_inside(href: str) -> bool:
    return href.startswith('#') or href.lower().startswith(_PICTURES)


def _refers_inside(style: str | None) -> bool:
    """Tell whether every ``url()`` of a style is a place in the file itself."""
    parts = (style or '').split('url(')[1:]
    return all(part.lstrip(' \'"').startswith('#') for part in parts)


def _is_hidden(element: ElementTree.Element) -> bool:
    style = element.get('style', '').replace(' ', '')
    return element.get('display') == 'none' or 'display:none' in style


def _layer(element: ElementTree.Element, parent: str) -> str:
    """Return the layer of an element: its own name if that says what it is, else its group's."""
    names = [v for k, v in element.attrib.items() if k.endswith('}label') or k in ('id', 'class')]
    for name in names:
        if layer_role(name) is not Role.UNKNOWN:
            return name
    is_named_group = _local(element) == 'g' and names and not parent
    return names[0] if is_named_group else parent


def _refuse_growth(root: ElementTree.Element, name: str) -> None:
    """Refuse trees that ``use`` makes grow without bounds, as by uses of uses or of themselves."""
    by_id = {element.get('id'): element for element in root.iter() if element.get('id')}
    sizes: dict[str, int] = {}

    def size(element: ElementTree.Element, depth: int) -> int:
        key = element.get(_NUMBER, '')
        if key in sizes:
            return sizes[key]
        sizes[key] = _MAX_ELEMENTS + 1  # while it is being counted: a use of itself
        total = 1 + sum(size(child, depth + 1) for child in element)
        if _local(element) == 'use':
            href = next((v for k, v in element.attrib.items() if k.endswith('href')), '')
            target = by_id.get(href[1:])
            total += size(target, depth + 1) if target is not None else 0
        sizes[key] = total
        return total

    drawn = sum(
        len(element.get('d', '')) + len(element.get('points', '')) for element in root.iter()
    )
    if drawn > _MAX_PATHS:
        raise MapFormatError(
            f'{name} is too large: expected at most {_MAX_PATHS // 2**20} MB of paths; remove '
            'hatches and furniture'
        )
    if size(root, 0) > _MAX_ELEMENTS:
        raise MapFormatError(
            f'{name} grows to more than {_MAX_ELEMENTS:,} elements when its <use> elements are '
            'replaced; save it as plain SVG'
        )


def _shapes(text: str, name: str) -> Any:
    from svgelements import SVG

    try:
        return SVG.parse(io.StringIO(text), ppi=96.0, reify=True)
    except Exception as error:  # svgelements raises many kinds on damaged attributes
        raise MapFormatError(
            f'{name} is a damaged SVG ({detail_of(error)}); save it again'
        ) from None


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
    builder: PageBuilder, shape: Any, clean: _Clean, clips: dict[str, tuple[Array, ...]]
) -> None:
    from svgelements import Image, Shape, Text

    values = getattr(shape, 'values', {})
    number = str(values.get(_NUMBER, ''))
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
            width=_number(shape.stroke_width),
            is_dashed=_is_dashed(values.get('stroke-dasharray')),
            is_even_odd=values.get('fill-rule') == 'evenodd',
            layer=layer,
            clip=box,
            mask=mask,
        )
        builder.add(_rings(shape), paint)


def _clip_of(builder: PageBuilder, clips: list[tuple[Array, ...]]) -> tuple[Box, int]:
    """Return the box that all clip paths leave, and the mask of the innermost that is no box."""
    box, mask = EVERYWHERE, -1
    for rings in clips:
        points = np.concatenate(rings)
        low, high = points.min(axis=0), points.max(axis=0)
        box = (
            max(box[0], float(low[0])),
            max(box[1], float(low[1])),
            min(box[2], float(high[0])),
            min(box[3], float(high[1])),
        )
        if len(rings) > 1 or not _is_box(rings[0]):
            if not builder.masks or builder.masks[-1] is not rings:
                builder.masks.append(rings)
            mask = len(builder.masks) - 1
    return box, mask


def _is_box(points: Array) -> bool:
    """Tell whether a ring fills its box."""
    x, y = (points - points[0]).T
    area = 0.5 * abs(float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))
    return bool(np.isclose(area, np.ptp(x) * np.ptp(y)))


def _add_picture(builder: PageBuilder, shape: Any) -> None:
    """Add a picture that lies within the file."""
    head, _, data = str(shape.url or '').partition(',')
    if not head.endswith('base64') or shape.width is None or shape.height is None:
        return
    try:
        pixels = _decoded(base64.b64decode(data, validate=False), builder.what)
    except (OSError, ValueError, SyntaxError) as error:
        raise MapFormatError(
            f'{builder.what} holds a damaged picture ({detail_of(error)}); save it without'
        ) from None
    A_page_user = _affine(shape.transform)
    size = _number(shape.width), _number(shape.height)
    scale = np.array([size[0] / pixels.shape[1], size[1] / pixels.shape[0]])
    A = np.hstack([A_page_user[:, :2] * scale, transformed(
        np.array([_number(shape.x), _number(shape.y)]) + 0.5 * scale, A_page_user
    )[:, None]])  # fmt: skip
    if np.isfinite(A).all():
        builder.pictures.append(Picture(pixels, A))


def _decoded(data: bytes, name: str) -> NDArray[np.uint8]:
    """Return the pixels ``(H, W, 3)`` of a picture on white."""
    from PIL import Image as PilImage

    PilImage.MAX_IMAGE_PIXELS = None  # of this process: the limit is the one below
    with PilImage.open(io.BytesIO(data), formats=('PNG', 'JPEG', 'GIF')) as image:
        if image.width * image.height > _MAX_PICTURE:
            raise MapFormatError(
                f'{name} holds a picture of {image.width} x {image.height} pixels: expected at '
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
    """Yield the rings of a shape, curves as short straight pieces."""
    from svgelements import Close, Line, Move
    from svgelements import Path as ShapePath

    points: list[tuple[float, float]] = []
    curve: list[bool] = []
    for segment in ShapePath(shape):
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
            steps = np.linspace(0.0, 1.0, _CURVE_STEPS + 1)[1:]
            if curve:
                curve[-1] = True
            points.extend(_xy(segment.point(t)) for t in steps)
            curve.extend([True] * (_CURVE_STEPS - 1) + [False])
    yield from _ring(points, curve, False)


def _xy(point: Any) -> tuple[float, float]:
    return float(point.x), float(point.y)


def _ring(points: list[tuple[float, float]], curve: list[bool], is_closed: bool) -> Iterator[Ring]:
    if len(points) > 1:
        yield Ring(np.array(points), np.array(curve[: len(points)]), is_closed)


def _label(shape: Any) -> Label | None:
    """Return a text; its box is estimated from its size and number of letters."""
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
