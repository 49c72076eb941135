# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Floorplan model of a parsed drawing, from its file or from the segmented map."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.model import FloorplanModel, ModelDoor, ModelRoom, ModelWall, Rings
from fpnet_core.drawings.room_names import printed_rooms
from fpnet_core.drawings.room_texts import PrintedRoom
from fpnet_core.drawings.types import Array, Reading
from fpnet_core.types import OCCUPIED, GridMap, Segmentation

_FINER = 4  # numerical: pixels per cell edge, so that outlines follow the edges of cells
_STRAIGHT = 1.05  # numerical: tolerance that straightens staircase outlines [cells]
_SAME = 0.5  # of a door's width: a drawn and a segmented door this close are the same; chosen
_LEAST_CELLS = 4  # numerical: smaller wall components are dropped
_SOURCE = 'segmentation'


def complete_model(reading: Reading) -> FloorplanModel:
    """
    Return the model of a parse result, completed by segmented rooms and doors if not stated.

    Coordinates are metres of the parsed map; rooms have the number, name and area printed in them.
    """
    stated, segmentation = reading.model, reading.segmentation
    known = stated.doors if stated is not None else ()
    if stated is not None and stated.states_rooms:
        return stated
    rooms = tuple(_rooms(reading, segmentation))
    if stated is not None and stated.is_whole and known:
        return replace(stated, rooms=rooms)
    doors = tuple(
        _door(portal.ends, segmentation.regions[portal.door].confidence, known)
        for portal in segmentation.portals
        if (portal.ends[0] != portal.ends[1]).any()
    )
    if stated is not None and stated.is_whole:
        return replace(stated, rooms=rooms, doors=doors)
    grid = segmentation.grid
    is_wall = grid.cells == OCCUPIED
    return FloorplanModel(
        walls=tuple(ModelWall(rings, source=_SOURCE) for rings in areas_of(is_wall, grid)),
        doors=doors,
        rooms=rooms,
        outline=tuple(rings[0] for rings in areas_of(is_wall | (segmentation.labels > 0), grid)),
        scale=reading.scale,
        H_plan_image=reading.H_plan_image,
    )


def _door(ends: Array, probability: float, known: tuple[ModelDoor, ...]) -> ModelDoor:
    """Return the drawn door at a segmented opening, else a door made of the opening."""
    middle = ends.mean(axis=0)
    for door in known:
        if np.hypot(*(door.ends.mean(axis=0) - middle)) < _SAME * door.width_m:
            return replace(door, probability=max(door.probability, probability))
    return ModelDoor(ends, probability=probability, source=_SOURCE)


def _rooms(reading: Reading, segmentation: Segmentation) -> list[ModelRoom]:
    printed = printed_rooms(reading, segmentation)
    rooms = []
    for region in segmentation.rooms:
        areas = areas_of(segmentation.labels == region.id + 1, segmentation.grid)
        if areas:
            rings = max(areas, key=lambda each: cv2.contourArea(each[0].astype(np.float32)))
            texts = printed.get(region.id + 1, PrintedRoom(region.id + 1))
            rooms.append(
                ModelRoom(
                    rings,
                    f'{texts.number} {texts.name}'.strip(),
                    texts.area_m2,
                    probability=region.confidence,
                    source=_SOURCE,
                )
            )
    return rooms


def areas_of(mask: NDArray[np.bool_], grid: GridMap) -> list[Rings]:
    """Return the rings [m] of each component of a mask, along cell edges, with holes."""
    rows, cols = np.nonzero(mask)
    if not len(rows):
        return []
    low = np.array([rows.min(), cols.min()])
    part = mask[low[0] : rows.max() + 1, low[1] : cols.max() + 1].astype(np.uint8)
    fine = part.repeat(_FINER, axis=0).repeat(_FINER, axis=1)
    contours, tree = cv2.findContours(fine, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    found: dict[int, list[Array]] = {}
    for number, contour in enumerate(contours):
        parent = int(tree[0][number][3])
        if parent < 0 and cv2.contourArea(contour) < _LEAST_CELLS * (_FINER - 1) ** 2:
            continue
        simple = cv2.approxPolyDP(contour, _STRAIGHT * _FINER, True)[:, 0, ::-1]
        if len(simple) > 2 and (parent < 0 or parent in found):
            rc = (simple + 0.5) / _FINER - 0.5 + low
            found.setdefault(number if parent < 0 else parent, []).append(grid.rc_to_xy(rc))
    return [tuple(rings) for rings in found.values()]
