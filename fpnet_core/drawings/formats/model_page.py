# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Floorplan models as vector pages, and choice of a storey, for formats of elements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fpnet_core.drawings.formats.pages import BLACK, PageBuilder, Paint, Ring, UnitKind, VectorPage
from fpnet_core.drawings.model import FloorplanModel
from fpnet_core.drawings.model_raster import WALL_M
from fpnet_core.drawings.types import Label, ReadOptions
from fpnet_core.errors import MapFormatError

_LETTER_M = 0.3  # height of rooms' names; chosen


def choose_storey(
    name: str, names: Sequence[str], counts: Sequence[int], options: ReadOptions
) -> tuple[int, list[str]]:
    """
    Return the index of the requested storey, else of the one with most elements, and a note.

    Raises
    ------
    MapFormatError
        If there is no such storey.
    """
    number = int(np.argmax(counts)) if options.page is None else options.page - 1
    if not 0 <= number < len(names):
        raise MapFormatError(f'{name} has {len(names)} storeys; there is no storey {options.page}')
    if not counts[number]:
        raise MapFormatError(
            f'{name} has no elements on storey {number + 1} of {len(names)}, {names[number]}; '
            'choose another one with --page'
        )
    return number, [f'storey {number + 1} of {len(names)} from below: {names[number]}']


def page_of(name: str, model: FloorplanModel, notes: Sequence[str]) -> VectorPage:
    """Return a model in metres as a page: filled walls, outlines of rooms with their names."""
    builder = PageBuilder(name, notes=list(notes))
    for wall in model.walls:
        rings = [Ring(ring, is_closed=True) for ring in wall.rings]
        builder.add(rings, Paint(BLACK, is_even_odd=True, layer='walls'))
    for window in model.windows:
        builder.add([Ring(window.ends)], Paint(stroke=BLACK, width=WALL_M, layer='windows'))
    for room in model.rooms:
        rings = [Ring(ring, is_closed=True) for ring in room.rings]
        layer = 'rooms' if model.walls else 'walls'
        width = 0.0 if model.walls else WALL_M
        builder.add(rings, Paint(stroke=BLACK, width=width, layer=layer))
        if room.name:
            x, y = (float(each) for each in room.rings[0].mean(axis=0))
            half = 0.3 * _LETTER_M * len(room.name)
            box = (x - half, y - 0.5 * _LETTER_M, x + half, y + 0.5 * _LETTER_M)
            builder.labels.append(Label(room.name, box))
    page = builder.finish(is_y_up=True, unit_m=1.0, unit_kind=UnitKind.TRUE)
    return replace(page, model=model)
