# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sanitization of SVG files: no nested entities, no scripts, no external references."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
import re
from xml.etree import ElementTree
from xml.parsers import expat
import zlib

from fpnet_core.drawings.formats.layers import LayerRole, layer_role
from fpnet_core.drawings.formats.messages import detail_of
from fpnet_core.errors import MapFormatError

MAX_BYTES = 64 * 2**20
"""Numerical: of an SVG after unpacking."""
NUMBER = 'data-fpnet'
"""Attribute with the number of an element."""
_MAX_ELEMENTS = 300_000  # numerical
_MAX_PATHS = 8 * 2**20  # numerical: characters of path data, half a million segments
_MAX_DEPTH = 900  # numerical: nested groups; converters from PDF nest one per clip path
# Numerical: characters of an entity; drawing programs store their namespaces in entities.
_MAX_ENTITY = 1_000
_DROPPED = frozenset({
    'script', 'foreignObject', 'animate', 'animateTransform', 'animateMotion', 'animateColor',
    'set', 'handler', 'listener', 'iframe', 'audio', 'video', 'a11y', 'metadata', 'namedview',
})  # fmt: skip
_PICTURES = ('data:image/png', 'data:image/jpeg', 'data:image/jpg', 'data:image/gif')
_MAX_CLIPS = 12  # numerical: innermost clip paths of an element that are applied
_MAX_CLIP_SHAPES = 50  # numerical
_CLIP = re.compile(r'(?:^|clip-path:\s*)url\(\s*["\']?#([^"\')\s]+)')
_CLIP_SHAPES = frozenset({'path', 'rect', 'circle', 'ellipse', 'polygon', 'polyline'})
_GEOMETRY = frozenset({
    'd', 'x', 'y', 'width', 'height', 'cx', 'cy', 'r', 'rx', 'ry', 'points', 'transform',
})  # fmt: skip
_HIDING = re.compile(r'display\s*:\s*none\s*;?')
_SVG = 'http://www.w3.org/2000/svg'


@dataclass
class Clean:
    """
    A sanitized tree: layers of its numbered elements, and what was dropped.

    ``clips`` are the numbers of the groups that clip an element: copies of clip paths next to it,
    which the library transforms like shapes.
    """

    root: ElementTree.Element
    by_id: dict[str, ElementTree.Element] = field(default_factory=dict)
    layers: dict[str, str] = field(default_factory=dict)
    clips: dict[str, tuple[str, ...]] = field(default_factory=dict)
    shapes_of_clips: set[str] = field(default_factory=set)
    count: int = 0
    dropped: set[str] = field(default_factory=set)
    wanted: frozenset[str] = frozenset()


def unpacked(path: Path) -> bytes:
    """Return the XML of an SVG or SVGZ file; MapFormatError if it is too large or damaged."""
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


def parse(data: bytes, name: str) -> ElementTree.Element:
    """Return the tree of an XML text; nested and external entities are rejected."""
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
                f'{name} defines the entity {key[:40]!a}, which expands or refers to another '
                'file; save it as plain SVG'
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


def cleaned(root: ElementTree.Element, name: str, wanted: Iterable[str] = ()) -> Clean:
    """
    Return the sanitized document; MapFormatError if it is no SVG.

    Groups named in ``wanted``, and all within, are layers of that name, shown even if hidden.
    """
    if _local(root) != 'svg':
        raise MapFormatError(f'{name} is XML, but not SVG: its root is {_local(root)[:40]!a}')
    clean = Clean(root, wanted=frozenset(each.casefold() for each in wanted))
    for element in root.iter():
        clean.by_id[element.get('id', '')] = element
        if _local(element) == 'path':
            element.attrib.setdefault('d', '')  # glyphs of spaces have none; libraries need one
    _clean_element(clean, root, '', ())
    _refuse_growth(root, name)
    return clean


def _clean_element(
    clean: Clean, element: ElementTree.Element, layer: str, clips: tuple[str, ...]
) -> None:
    number = _numbered(clean, element)
    layer = clean.layers[number] = _layer(clean, element, layer)
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
        _show(clean, child)
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


def _numbered(clean: Clean, element: ElementTree.Element) -> str:
    clean.count += 1
    element.set(NUMBER, str(clean.count))
    return str(clean.count)


def _clip_copy(clean: Clean, parent: ElementTree.Element, element: ElementTree.Element) -> str:
    """Insert a copy of an element's clip path beside it; return its number, empty if none."""
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
            clean.clips[copied.get(NUMBER, '')] = (number,)
    parent.append(group)
    return number


def _is_inside(href: str) -> bool:
    return href.startswith('#') or href.lower().startswith(_PICTURES)


def _refers_inside(style: str | None) -> bool:
    """Return whether every ``url()`` of a style refers to the file itself."""
    parts = (style or '').split('url(')[1:]
    return all(part.lstrip(' \'"').startswith('#') for part in parts)


def _is_hidden(element: ElementTree.Element) -> bool:
    style = element.get('style', '').replace(' ', '')
    return element.get('display') == 'none' or 'display:none' in style


def _show(clean: Clean, element: ElementTree.Element) -> None:
    """Show a hidden element if its name is wanted."""
    if clean.wanted and _is_hidden(element) and _wanted(clean, _names(element)):
        element.attrib.pop('display', None)
        element.set('style', _HIDING.sub('', element.get('style', '')))


def _names(element: ElementTree.Element) -> list[str]:
    return [v for k, v in element.attrib.items() if k.endswith('}label') or k in ('id', 'class')]


def _wanted(clean: Clean, names: list[str]) -> str:
    """Return the wanted name, empty if none is; each word of a class is a name."""
    every = [*names, *(word for name in names for word in name.split())]
    return next((name for name in every if name.casefold() in clean.wanted), '')


def _layer(clean: Clean, element: ElementTree.Element, parent: str) -> str:
    """
    Return the layer of an element: its own name if recognized, else that of its group.

    A wanted layer holds all elements in it, whatever their names.
    """
    if parent.casefold() in clean.wanted:
        return parent
    names = _names(element)
    if clean.wanted and (name := _wanted(clean, names)):
        return name
    for name in names:
        if layer_role(name) is not LayerRole.UNKNOWN:
            return name
    is_named_group = _local(element) == 'g' and names and not parent
    return names[0] if is_named_group else parent


def _refuse_growth(root: ElementTree.Element, name: str) -> None:
    """Reject trees that expand without bounds by nested or recursive ``use``."""
    by_id = {element.get('id'): element for element in root.iter() if element.get('id')}
    sizes: dict[str, int] = {}

    def size(element: ElementTree.Element, depth: int) -> int:
        key = element.get(NUMBER, '')
        if key in sizes:
            return sizes[key]
        sizes[key] = _MAX_ELEMENTS + 1  # while it is being counted: recursive use
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
            f'{name} expands to more than {_MAX_ELEMENTS:,} elements when its <use> elements are '
            'replaced; save it as plain SVG'
        )
