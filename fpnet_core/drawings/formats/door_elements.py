# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Doors of a vector drawing, from door symbols or door layers, as elements of a model."""

from __future__ import annotations

import numpy as np

from fpnet_core.drawings.formats.door_strokes import DoorStrokes
from fpnet_core.drawings.formats.doors import Doors
from fpnet_core.drawings.formats.pages import Array, VectorPage
from fpnet_core.drawings.model import DoorKind, FloorplanModel, ModelDoor

_MEET = 0.15  # of a leaf: largest gap between the closed leaves of a double door; chosen
_ALIKE = 1.6  # largest ratio of the two leaves of a double door; chosen
_MOST = 3_000  # numerical: largest number of doors in a drawing
_FLAT = 1e-12  # numerical: determinant below which a file's transform is singular
_PROBABILITY = 0.95  # chosen: probability that a detected door is one


def drawn_model(page: VectorPage, doors: Doors, others: DoorStrokes) -> FloorplanModel | None:
    """Return the doors of a page in the file's own coordinates; None without doors."""
    is_flat = abs(np.linalg.det(page.A_page_file[:, :2])) < _FLAT
    count = len(doors.width) + len(others.depth)
    if is_flat or not 0 < count <= _MOST:
        return None
    found = []
    partner = _partners(doors) if len(doors.width) else []
    for number, other in enumerate(partner):
        hinge, shut, leaf = doors.hinge[number], doors.shut[number], doors.leaf[number]
        if other < 0:
            found.append(_door(np.array([hinge, shut]), DoorKind.SWING, leaf))
        elif number < other:
            found.append(_door(np.array([hinge, doors.hinge[other]]), DoorKind.DOUBLE, None))
    for ends, depth in zip(others.ends, others.depth.tolist(), strict=True):
        found.append(ModelDoor(ends, depth, probability=_PROBABILITY, source='layer of doors'))
    A_file_page = np.linalg.inv(np.vstack([page.A_page_file, [0.0, 0.0, 1.0]]))[:2]
    return FloorplanModel(doors=tuple(found), is_whole=False).moved(A_file_page)


def _door(ends: Array, kind: DoorKind, leaf: Array | None) -> ModelDoor:
    hinge = 0 if leaf is not None else None
    return ModelDoor(ends, 0.0, kind, hinge, leaf, '', _PROBABILITY, 'door symbol')


def _partners(doors: Doors) -> list[int]:
    """Return the index of the other leaf of a double door for each leaf; -1 without one."""
    count = len(doors.width)
    apart = np.hypot(*(doors.shut[:, None] - doors.shut).transpose(2, 0, 1))
    hinges = np.hypot(*(doors.hinge[:, None] - doors.hinge).transpose(2, 0, 1))
    both = doors.width[:, None] + doors.width
    ratio = np.abs(np.log(doors.width[:, None] / doors.width))
    meets = (apart < 0.5 * _MEET * both) & (ratio < np.log(_ALIKE))
    meets &= hinges > (1.0 - _MEET) * both
    np.fill_diagonal(meets, False)
    best = np.where(meets.any(axis=1), np.argmin(np.where(meets, apart, np.inf), axis=1), -1)
    return [
        int(other) if other >= 0 and best[other] == number else -1
        for number, other in zip(range(count), best, strict=True)
    ]
