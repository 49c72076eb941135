# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Opening of drawing files; their first bytes decide the format, not their names."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
import re

from fpnet_core.drawings.ocr import with_texts
from fpnet_core.drawings.types import Drawing, ReadOptions
from fpnet_core.errors import MapFormatError
from fpnet_core.plain_files import regular

RMF_SUFFIX = '.building.yaml'
"""Given: suffix of files of Open-RMF's traffic editor."""

_HEAD_BYTES = 4096  # numerical: read to detect the format
_DXF = re.compile(rb'\A(?:\xef\xbb\xbf)?\s*(?:999\r?\n[^\n]*\n\s*)*0\s*\r?\n\s*SECTION\s*\r?\n')
_SVG = re.compile(rb'<(?:\w+:)?svg[\s>]')
_IMAGES = (
    b'\x89PNG', b'\xff\xd8\xff', b'BM', b'II*\0', b'MM\0*', b'P1', b'P2', b'P3', b'P4', b'P5',
    b'P6', b'GIF8',
)  # fmt: skip
_SUFFIXES = {
    'pdf': ('.pdf', '.ai'),
    'svg': ('.svg', '.svgz'),
    'dxf': ('.dxf',),
    'ifc': ('.ifc',),
    'geojson': ('.geojson', '.imdf'),
    'image': (
        '.png', '.jpg', '.jpeg', '.jpe', '.webp', '.gif', '.bmp', '.tif', '.tiff', '.pgm', '.ppm',
        '.pbm', '.pnm',
    ),
}  # fmt: skip
_BY_CONTENT = (
    (
        b'AC10',
        'an AutoCAD drawing (DWG): convert it to DXF with the ODA File Converter or LibreCAD',
    ),
    (
        b'AC1.',
        'an AutoCAD drawing (DWG): convert it to DXF with the ODA File Converter or LibreCAD',
    ),
    (b'%!PS', 'PostScript: convert it to PDF with Ghostscript (ps2pdf) or Inkscape'),
    (b'\xc5\xd0\xd3\xc6', 'PostScript: convert it to PDF with Ghostscript (ps2pdf) or Inkscape'),
    (b'AutoCAD-DWF', 'a DWF: print it to PDF with Autodesk Design Review'),
    (b'(DWF V', 'a DWF: print it to PDF with Autodesk Design Review'),
    (b'7z\xbc\xaf', 'an archive: unpack it first'),
    (b'Rar!', 'an archive: unpack it first'),
)
_BY_SUFFIX = {
    '.dwg': 'an AutoCAD drawing: convert it to DXF with the ODA File Converter or LibreCAD',
    '.dwf': 'a DWF: print it to PDF with Autodesk Design Review',
    '.dgn': 'a MicroStation drawing: save it as DXF with MicroStation or the ODA File Converter',
    '.rvt': 'a Revit model: export it as IFC or print the storey to PDF with Revit',
    '.skp': 'a SketchUp model: export it as IFC or DXF with SketchUp',
    '.3dm': 'a Rhino model: export it as DXF with Rhino',
    '.pln': 'an ArchiCAD model: export it as IFC or DXF with ArchiCAD',
    '.cdr': 'a CorelDRAW drawing: export it as SVG or PDF with CorelDRAW or Inkscape',
    '.vsd': 'a Visio drawing: export it as SVG or PDF with Visio or LibreOffice Draw',
    '.vsdx': 'a Visio drawing: export it as SVG or PDF with Visio or LibreOffice Draw',
    '.doc': 'a Word document: print it to PDF with LibreOffice',
    '.docx': 'a Word document: print it to PDF with LibreOffice',
    '.odt': 'a text document: print it to PDF with LibreOffice',
    '.odg': 'a drawing of LibreOffice: export it as SVG or PDF with LibreOffice Draw',
    '.ppt': 'a presentation: print it to PDF with LibreOffice',
    '.pptx': 'a presentation: print it to PDF with LibreOffice',
    '.xlsx': 'a spreadsheet: print it to PDF with LibreOffice',
    '.ifczip': 'a packed IFC: unpack it first',
    '.ifcxml': 'IFC in XML: convert it to .ifc with IfcConvert',
    '.sh3d': 'a Sweet Home 3D home: export it as SVG or PDF with Sweet Home 3D',
    '.eps': 'PostScript: convert it to PDF with Ghostscript (ps2pdf) or Inkscape',
    '.heic': 'a HEIC photograph: convert it to JPEG with heif-convert or ImageMagick',
    '.heif': 'a HEIF photograph: convert it to JPEG with heif-convert or ImageMagick',
    '.avif': 'an AVIF picture: convert it to PNG with ImageMagick',
    '.zip': 'an archive: unpack it first',
}
_PAGED = ('pdf', 'ifc', 'geojson', 'rmf')  # given: like TIFF; a storey counts as a page
_LAYERLESS = ('geojson', 'rmf')  # given: formats without layers
_SUPPORTED = 'PNG, JPEG, TIFF, WebP, GIF, BMP, PGM, PDF, SVG, DXF, IFC or IMDF'


def open_drawing(path: Path, options: ReadOptions = ReadOptions()) -> Drawing:  # noqa: B008
    """
    Return the content of a file of any supported format.

    Vector formats are read in a subprocess limited to 1.6 GB and 15 s.

    Raises
    ------
    MapFormatError
        If the file is missing, empty, a folder, damaged, encrypted, too large, or of an
        unsupported format (the one-line message names a converter), or if a page or layers are
        given for a format that has none.
    """
    path = Path(path)
    kind = drawing_kind(path)
    if kind == 'image':
        from fpnet_core.drawings.formats.images import open_image

        if options.layers:
            raise MapFormatError(f'{path} is an image, which has no layers; omit the layers')
        drawing = with_texts(open_image(path, options.page, options.crop), options)
    else:
        from fpnet_core.drawings.formats.worker import read_apart

        if options.page is not None and kind not in _PAGED:
            raise MapFormatError(f'{path} is {_named(kind)}, which has no pages; omit the page')
        if options.layers and kind in _LAYERLESS:
            raise MapFormatError(f'{path} is {_named(kind)}, which has no layers; omit the layers')
        drawing = with_texts(read_apart(path, kind, options), options)
    suffix = path.suffix.lower()
    others = [
        suffix for other, suffixes in _SUFFIXES.items() if other != kind for suffix in suffixes
    ]
    if suffix in others:
        note = f'its suffix is {suffix}, but it contains {_named(kind)}'
        drawing = replace(drawing, notes=(*drawing.notes, note))
    return drawing


def _named(kind: str) -> str:
    return {
        'image': 'an image', 'svg': 'an SVG', 'ifc': 'an IFC', 'geojson': 'a GeoJSON',
        'rmf': 'an Open-RMF building',
    }.get(kind, f'a {kind.upper()}')  # fmt: skip


def drawing_kind(path: Path) -> str:
    """
    Return ``image``, ``pdf``, ``svg``, ``dxf``, ``ifc``, ``geojson`` or ``rmf``.

    Raises
    ------
    MapFormatError
        If the file is missing, empty, a folder without GeoJSON, or of another format.
    """
    if path.is_dir() and any(path.glob('*.geojson')):
        return 'geojson'
    head = _head(path)
    is_step = path.suffix.lower() in ('.stp', '.step')
    is_packed = head.startswith(b'\x1f\x8b') and path.suffix.lower() == '.svgz'
    kinds = {
        'rmf': path.name.lower().endswith(RMF_SUFFIX),
        'geojson': _is_geojson(path, head),
        'pdf': b'%PDF-' in head[:1024],
        'dxf': head.startswith(b'AutoCAD Binary DXF') or bool(_DXF.match(head)),
        'ifc': b'ISO-10303-21' in head[:1024] and not is_step,
        'image': head.startswith(_IMAGES) or head[8:12] == b'WEBP',
        'svg': is_packed or bool(_SVG.search(_as_bytes(head))),
    }
    for kind, is_it in kinds.items():
        if is_it:
            return kind
    raise MapFormatError(_refusal(path, head))


def _is_geojson(path: Path, head: bytes) -> bool:
    """Return whether a file is GeoJSON or a ZIP that contains GeoJSON, such as IMDF."""
    text = _as_bytes(head).lstrip(b'\xef\xbb\xbf \r\n\t')
    if text.startswith(b'{'):
        return b'"Feature' in text or path.suffix.lower() == '.geojson'
    if not head.startswith(b'PK\x03\x04'):
        return False
    import zipfile

    try:
        with zipfile.ZipFile(path) as archive:
            return any(name.lower().endswith('.geojson') for name in archive.namelist())
    except Exception:  # damaged archives raise many exception types
        return False


def _head(path: Path) -> bytes:
    try:
        if path.is_dir():
            raise MapFormatError(f'{path} is a folder: expected a drawing; name a file in it')
        with regular(path).open('rb') as stream:
            head = stream.read(_HEAD_BYTES)
    except FileNotFoundError:
        raise MapFormatError(
            f'{path} does not exist: expected a drawing; check its name'
        ) from None
    except (OSError, ValueError) as error:
        detail = error.strerror if isinstance(error, OSError) else error
        raise MapFormatError(f'{path} cannot be read ({detail}); check the file') from None
    if not head.strip(b'\0 \r\n\t'):
        raise MapFormatError(f'{path} is empty: expected a drawing; copy or export it again')
    return head


def _as_bytes(head: bytes) -> bytes:
    """Return UTF-16 text without its zero bytes; other bytes unchanged."""
    return head.replace(b'\0', b'') if head[:2] in (b'\xff\xfe', b'\xfe\xff') else head


def _refusal(path: Path, head: bytes) -> str:
    """Return the one-line error message for an unsupported file."""
    what = next((text for magic, text in _BY_CONTENT if head.startswith(magic)), None)
    if head[4:8] == b'ftyp':
        what = 'a HEIC or AVIF picture: convert it to JPEG with heif-convert or ImageMagick'
    what = what or _BY_SUFFIX.get(path.suffix.lower())
    if what is None and path.suffix.lower() in known_suffixes():
        what = f'not {path.suffix[1:].upper()} despite its suffix: export it again'
    if what is None and head.startswith(b'PK'):
        what = 'an archive: unpack it first'
    if what is None:
        what = f'of an unsupported format: expected {_SUPPORTED}'
    return f'{path} is {what}'


def known_suffixes() -> tuple[str, ...]:
    """Return the suffixes of supported drawings."""
    return tuple(suffix for suffixes in _SUFFIXES.values() for suffix in suffixes)
