# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of a floorplan's rooms, as the file states them or as they are printed in the rooms."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from fpnet_core.drawings.room_texts import PrintedRoom, mapped, printed_of_rooms
from fpnet_core.drawings.types import Reading, RoomName
from fpnet_core.raster.pixels import pixel_to_xy

if TYPE_CHECKING:
    from fpnet_core.drawings.model import ModelRoom
    from fpnet_core.types import Segmentation


def room_names(reading: Reading) -> tuple[RoomName, ...]:
    """
    Return the names of a parsed floorplan's rooms, each with a point in its room.

    A room without a name is left out. Texts on pictures need the extra ``ocr``.
    """
    model = reading.model
    if reading.names or (model is not None and model.states_rooms):
        stated = () if model is None else tuple(_stated(model.rooms))
        return reading.names or stated
    if not reading.drawing.labels:
        return ()
    segmentation = reading.segmentation
    found = printed_rooms(reading, segmentation)
    points = _points_inside(segmentation)
    names = ((label, f'{text.number} {text.name}'.strip()) for label, text in found.items())
    return tuple(RoomName(name, points[label]) for label, name in names if name)


def printed_rooms(reading: Reading, segmentation: Segmentation) -> dict[int, PrintedRoom]:
    """Return the texts printed in each room, by the room's label in the segmentation."""
    H_cell_image = np.linalg.inv(pixel_to_xy(segmentation.grid).matrix) @ reading.H_plan_image
    labels = mapped(reading.drawing.labels, np.asarray(H_cell_image, np.float64))
    found = printed_of_rooms(labels, np.asarray(segmentation.labels[::-1]))
    return {each.label: each for each in found}


def _stated(rooms: tuple[ModelRoom, ...]) -> Iterator[RoomName]:
    import shapely  # slow to import

    for room in rooms:
        if room.name:
            inside = shapely.Polygon(room.rings[0], room.rings[1:]).representative_point()
            yield RoomName(room.name, (inside.x, inside.y))


def _points_inside(segmentation: Segmentation) -> dict[int, tuple[float, float]]:
    """Return by label the centre of the cell of each room nearest to the room's centroid [m]."""
    found = {}
    for room in segmentation.rooms:
        cells = np.argwhere(segmentation.labels == room.id + 1)
        nearest = cells[((cells - cells.mean(axis=0)) ** 2).sum(axis=1).argmin()]
        x, y = segmentation.grid.rc_to_xy(nearest[None] + 0.0)[0].tolist()
        found[room.id + 1] = (x, y)
    return found
