# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reader of PDF: paths with widths and colours, texts with boxes, and scans, of one page.

PDFium reads the file; scripts, links and attachments are ignored.
"""

from __future__ import annotations

from collections.abc import Iterator
import ctypes
from dataclasses import dataclass, field, replace
import itertools
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.formats.messages import detail_of
from fpnet_core.drawings.formats.page_texts import merge_labels
from fpnet_core.drawings.formats.pages import (
    EVERYWHERE,
    MAX_NESTED,
    NO_PAINT,
    Array,
    Box,
    Canvas,
    Colour,
    PageBuilder,
    Paint,
    Ring,
    VectorPage,
    bezier,
    composed,
    narrowed,
    transformed,
)
from fpnet_core.drawings.formats.painting import MIN_WIDTH_PX
from fpnet_core.drawings.lengths import INCH_M
from fpnet_core.drawings.types import Label, ReadOptions
from fpnet_core.errors import MapFormatError
from fpnet_core.geometry import scale_of

POINT_M = INCH_M / 72.0
"""Given: length of a PDF's unit on paper [m]."""

_LARGEST_PAGE = 1e7  # numerical: points along a side, 3.5 km
_MAX_PAGES = 60  # numerical: pages searched for a floorplan
_MAX_LOOKED = 4_000  # numerical: objects of a page evaluated in that search
_MAX_OBJECTS = 600_000  # numerical: on a page
# Chosen, not measured:
_SCAN_SHARE = 0.3  # of the page covered by images, from which it is a scan
_RULED = 0.02  # of the page's diagonal: shortest line that counts for a drawing
_SCAN_LINES = 400  # number of lines that a scan counts for
_LONGEST_TEXT = 2_000  # numerical: longer text objects are skipped [bytes]


@dataclass
class _Reader:
    """State of the traversal of a page's objects."""

    raw: Any
    text_page: Any
    builder: PageBuilder
    A_top_page: Array
    paths: list[tuple[Any, float]] = field(default_factory=list)
    others: list[Any] = field(default_factory=list)
    count: int = 0
    picture_area: float = 0.0


def load_libraries() -> None:
    """Import the libraries of this reader before the process is restricted."""
    import pypdfium2.raw  # noqa: F401


def read_pdf(path: Path, options: ReadOptions) -> VectorPage:
    """
    Return a page of a PDF: the requested one, else the one with most long lines.

    Raises
    ------
    MapFormatError
        If the file is encrypted, damaged, too large, or lacks the page.
    """
    import pypdfium2

    try:
        document = pypdfium2.PdfDocument(path)
        number, note = _page_number(document, path, options)
        page = document[number]
    except pypdfium2.PdfiumError as error:
        raise MapFormatError(_refusal(path, detail_of(error))) from None
    result = _read_page(page, path.name)
    return replace(result, notes=(*result.notes, note)) if note else result


def _refusal(path: Path, detail: str) -> str:
    if 'password' in detail.lower():
        return f'{path.name} is encrypted: expected a PDF without a password; save it without one'
    return f'{path.name} is a damaged PDF ({detail}); print it to a new PDF file'


def _page_number(document: Any, path: Path, options: ReadOptions) -> tuple[int, str]:
    count = len(document)
    if options.page is not None:
        if not 1 <= options.page <= count:
            raise MapFormatError(f'{path.name} has {count} pages; there is no page {options.page}')
        return options.page - 1, ''
    if count <= 1:
        return 0, ''
    scores = [_drawing_score(document[k]) for k in range(min(count, _MAX_PAGES))]
    best = int(np.argmax(scores))
    return best, f'page {best + 1} of {count} looks most like a floorplan'


def _drawing_score(page: Any) -> float:
    """Return a page's score as a drawing: its long lines, and many for a scan."""
    from pypdfium2 import raw

    width, height = page.get_size()
    diagonal = float(np.hypot(width, height))
    lines = 0
    for obj in itertools.islice(page.get_objects(max_depth=3), _MAX_LOOKED):
        box = obj.get_bounds()
        size = max(box[2] - box[0], box[3] - box[1])
        if obj.type == raw.FPDF_PAGEOBJ_PATH:
            lines += int(size > _RULED * diagonal)
        elif obj.type == raw.FPDF_PAGEOBJ_IMAGE:
            area = (box[2] - box[0]) * (box[3] - box[1])
            lines += _SCAN_LINES * int(area > _SCAN_SHARE * width * height)
    return float(lines)


def _read_page(page: Any, name: str) -> VectorPage:
    from pypdfium2 import raw

    width, height = page.get_size()
    if not (0.0 < width < _LARGEST_PAGE and 0.0 < height < _LARGEST_PAGE):
        raise MapFormatError(f'{name} has a page of {width:g} x {height:g} points; print it again')
    A_top_page = _upright(page)
    reader = _Reader(raw, page.get_textpage(), PageBuilder(name), A_top_page)
    objects = [raw.FPDFPage_GetObject(page, k) for k in range(raw.FPDFPage_CountObjects(page))]
    _walk(reader, objects, np.eye(2, 3), EVERYWHERE, 0)
    reader.builder.labels[:] = merge_labels(reader.builder.labels)
    is_scan = reader.picture_area > _SCAN_SHARE * width * height
    if is_scan:
        reader.others.clear()
        reader.builder.notes.append('the page is a scan')
    result = reader.builder.finish(box=(0.0, 0.0, width, height), paper_m=POINT_M)
    return result.with_renderer(_Renderer(reader, page, (width, height)), is_scan)


def _upright(page: Any) -> Array:
    """Return the affine from PDF coordinates to points from the top left of the page as shown."""
    left, bottom, right, top = page.get_cropbox()
    media = page.get_mediabox()
    left, bottom = max(left, media[0]), max(bottom, media[1])
    right, top = min(right, media[2]), min(top, media[3])
    match page.get_rotation():
        case 90:
            return np.array([[0.0, 1.0, -bottom], [1.0, 0.0, -left]])
        case 180:
            return np.array([[-1.0, 0.0, right], [0.0, 1.0, -bottom]])
        case 270:
            return np.array([[0.0, -1.0, top], [-1.0, 0.0, right]])
    return np.array([[1.0, 0.0, -left], [0.0, -1.0, top]])


def _walk(reader: _Reader, objects: list[Any], A_page_form: Array, clip: Box, depth: int) -> None:
    raw = reader.raw
    for obj in objects:
        reader.count += 1
        if reader.count > _MAX_OBJECTS:
            raise MapFormatError(
                f'{reader.builder.what} is too large: expected at most {_MAX_OBJECTS:,} objects '
                'on a page; export it without hatches and furniture'
            )
        match raw.FPDFPageObj_GetType(obj):
            case raw.FPDF_PAGEOBJ_PATH:
                _add_path(reader, obj, A_page_form, clip)
            case raw.FPDF_PAGEOBJ_TEXT:
                _add_text(reader, obj, A_page_form)
            case raw.FPDF_PAGEOBJ_IMAGE:
                reader.others.append(obj)
                reader.picture_area += _area(_bounds(reader, obj, A_page_form))
            case raw.FPDF_PAGEOBJ_FORM if depth < MAX_NESTED:
                count = raw.FPDFFormObj_CountObjects(obj)
                inner = [raw.FPDFFormObj_GetObject(obj, k) for k in range(count)]
                A = composed(A_page_form, _matrix(reader, obj))
                _walk(reader, inner, A, _clip(reader, obj, A_page_form, clip), depth + 1)


def _matrix(reader: _Reader, obj: Any) -> Array:
    matrix = reader.raw.FS_MATRIX()
    if not reader.raw.FPDFPageObj_GetMatrix(obj, matrix):
        return np.eye(2, 3)
    m = matrix
    return np.array([[m.a, m.c, m.e], [m.b, m.d, m.f]])


def _add_path(reader: _Reader, obj: Any, A_page_form: Array, clip: Box) -> None:
    raw = reader.raw
    mode, has_stroke = ctypes.c_int(), ctypes.c_int()
    raw.FPDFPath_GetDrawMode(obj, mode, has_stroke)
    A_page_path = composed(A_page_form, _matrix(reader, obj))
    A = composed(reader.A_top_page, A_page_path)
    stroke = _colour(raw.FPDFPageObj_GetStrokeColor, obj) if has_stroke.value else NO_PAINT
    fill = _colour(raw.FPDFPageObj_GetFillColor, obj) if mode.value else NO_PAINT
    if not (stroke[3] or fill[3]):
        reader.others.append(obj)
        return
    width = ctypes.c_float()
    raw.FPDFPageObj_GetStrokeWidth(obj, width)
    scale = float(scale_of(A[:, :2]))
    paint = Paint(
        fill=fill,
        stroke=stroke,
        width=float(width.value) * scale,
        is_dashed=raw.FPDFPageObj_GetDashCount(obj) > 0,
        is_even_odd=mode.value == raw.FPDF_FILLMODE_ALTERNATE,
        layer=_layer(raw, obj),
        clip=_clip(reader, obj, A_page_form, clip),
    )
    before = reader.builder.paths
    reader.builder.add(
        (Ring(transformed(r.points, A), r.is_curve, r.is_closed) for r in _rings(raw, obj)), paint
    )
    if reader.builder.paths > before:
        reader.paths.append((obj, scale))


def _colour(get: Any, obj: Any) -> Colour:
    parts = [ctypes.c_uint() for _ in range(4)]
    if not get(obj, *parts):
        return (0, 0, 0, 255)
    red, green, blue, opacity = (int(part.value) for part in parts)
    return red, green, blue, opacity


def _rings(raw: Any, obj: Any) -> Iterator[Ring]:
    """Yield the rings of a path object, in its own coordinates."""
    points: list[tuple[float, float]] = []
    curve: list[bool] = []
    controls: list[tuple[float, float]] = []
    x, y = ctypes.c_float(), ctypes.c_float()
    for k in range(raw.FPDFPath_CountSegments(obj)):
        segment = raw.FPDFPath_GetPathSegment(obj, k)
        raw.FPDFPathSegment_GetPoint(segment, x, y)
        kind = raw.FPDFPathSegment_GetType(segment)
        point = (x.value, y.value)
        if kind == raw.FPDF_SEGMENT_MOVETO:
            if len(points) > 1:
                yield _ring(points, curve, False)
            points, curve, controls = [point], [False], []
        elif kind == raw.FPDF_SEGMENT_BEZIERTO:
            controls.append(point)
            if len(controls) == 3 and points:
                arc = bezier([points[-1], *controls])[1:]
                curve[-1] = True
                points.extend(map(tuple, arc.tolist()))
                curve.extend([True] * (len(arc) - 1) + [False])
                controls = []
        else:
            points.append(point)
            curve.append(False)
        if raw.FPDFPathSegment_GetClose(segment) and len(points) > 1:
            yield _ring(points, curve, True)
            points, curve = [points[0]], [False]
    if len(points) > 1:
        yield _ring(points, curve, False)


def _ring(points: list[tuple[float, float]], curve: list[bool], is_closed: bool) -> Ring:
    return Ring(np.array(points), np.array(curve), is_closed)


def _clip(reader: _Reader, obj: Any, A_page_form: Array, outer: Box) -> Box:
    """Return the box ``outer`` clipped to an object's clip paths."""
    raw = reader.raw
    clip = raw.FPDFPageObj_GetClipPath(obj)
    count = raw.FPDFClipPath_CountPaths(clip) if clip else 0
    box = outer
    A = composed(reader.A_top_page, A_page_form)
    for k in range(max(count, 0)):
        points = _clip_points(raw, clip, k)
        if len(points):
            box = narrowed(box, transformed(points, A))
    return box


def _clip_points(raw: Any, clip: Any, path: int) -> Array:
    points = []
    x, y = ctypes.c_float(), ctypes.c_float()
    for k in range(max(raw.FPDFClipPath_CountPathSegments(clip, path), 0)):
        raw.FPDFPathSegment_GetPoint(raw.FPDFClipPath_GetPathSegment(clip, path, k), x, y)
        points.append((x.value, y.value))
    return np.array(points, dtype=np.float64).reshape(-1, 2)


def _bounds(reader: _Reader, obj: Any, A_page_form: Array) -> Box:
    """Return an object's box in points from the top left of the page."""
    parts = [ctypes.c_float() for _ in range(4)]
    if not reader.raw.FPDFPageObj_GetBounds(obj, *parts):
        return (0.0, 0.0, 0.0, 0.0)
    left, bottom, right, top = (part.value for part in parts)
    corners = np.array([[left, bottom], [left, top], [right, top], [right, bottom]])
    placed = transformed(corners, composed(reader.A_top_page, A_page_form))
    low, high = placed.min(axis=0), placed.max(axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _area(box: Box) -> float:
    return (box[2] - box[0]) * (box[3] - box[1])


def _add_text(reader: _Reader, obj: Any, A_page_form: Array) -> None:
    """Add a text object unless it is blank, invisible or without a finite box."""
    raw = reader.raw
    reader.others.append(obj)
    text = _text(reader, obj)
    box = _bounds(reader, obj, A_page_form)
    if text and np.isfinite(box).all() and raw.FPDFTextObj_GetTextRenderMode(obj) != 3:
        reader.builder.labels.append(Label(text, box))


def _text(reader: _Reader, obj: Any) -> str:
    raw = reader.raw
    size = raw.FPDFTextObj_GetText(obj, reader.text_page, None, 0)
    if not 2 < size <= _LONGEST_TEXT:
        return ''
    buffer = ctypes.create_string_buffer(size)
    raw.FPDFTextObj_GetText(
        obj, reader.text_page, ctypes.cast(buffer, ctypes.POINTER(raw.FPDF_WCHAR)), size
    )
    return buffer.raw.decode('utf-16-le', errors='replace').strip('\0').strip()


def _layer(raw: Any, obj: Any) -> str:
    """Return the optional content group of an object (a CAD layer); empty if it has none."""
    for k in range(max(raw.FPDFPageObj_CountMarks(obj), 0)):
        mark = raw.FPDFPageObj_GetMark(obj, k)
        if _mark_text(raw.FPDFPageObjMark_GetName, mark) == 'OC':
            return _mark_text(raw.FPDFPageObjMark_GetParamStringValue, mark, b'Name')
    return ''


def _mark_text(get: Any, *what: Any) -> str:
    buffer, size = (ctypes.c_ushort * 256)(), ctypes.c_ulong()
    if not get(*what, buffer, ctypes.sizeof(buffer), size) or size.value > ctypes.sizeof(buffer):
        return ''
    return bytes(buffer)[: size.value].decode('utf-16-le', errors='replace').strip('\0')


@dataclass(frozen=True)
class _Renderer:
    """Renderer by PDFium, which supports clipping, patterns and shadings."""

    reader: _Reader
    page: Any
    size: tuple[float, float]

    def __call__(self, is_path: NDArray[np.bool_], canvas: Canvas) -> NDArray[np.uint8]:
        """Return the image ``(H, W, 3)`` of the selected paths, and of scans."""
        raw, per_unit = self.reader.raw, canvas.pixels_per_unit
        for (obj, scale), keep in zip(self.reader.paths, is_path, strict=True):
            raw.FPDFPageObj_SetIsActive(obj, bool(keep))
            if keep and scale > 0.0:
                _widen(raw, obj, MIN_WIDTH_PX / (per_unit * scale))
        for obj in self.reader.others:
            raw.FPDFPageObj_SetIsActive(obj, False)
        height, width = canvas.shape
        pixels = np.full((height, width, 4), 255, np.uint8)
        bitmap = raw.FPDFBitmap_CreateEx(
            width, height, raw.FPDFBitmap_BGRx, pixels.ctypes.data, pixels.strides[0]
        )
        start = np.rint(canvas.A_pixel_page[:, 2] + 0.5).astype(int).tolist()
        size = [max(round(side * per_unit), 1) for side in self.size]
        flags = raw.FPDF_RENDER_NO_SMOOTHPATH | raw.FPDF_REVERSE_BYTE_ORDER
        raw.FPDF_RenderPageBitmap(bitmap, self.page, *start, *size, 0, flags)
        raw.FPDFBitmap_Destroy(bitmap)
        return np.ascontiguousarray(pixels[..., :3])


def _widen(raw: Any, obj: Any, least: float) -> None:
    width = ctypes.c_float()
    if raw.FPDFPageObj_GetStrokeWidth(obj, width) and width.value < least:
        raw.FPDFPageObj_SetStrokeWidth(obj, least)
