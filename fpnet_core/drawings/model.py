# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A storey of a building as a floorplan model: walls, doors, windows and rooms, not cells.

Places are metres in frame ``plan`` (x right, y up), where a reader does not say otherwise. Rings
are runs of corners, not closed; the first one of an area is its outside, further ones are holes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.types import Array, DrawingScale, ScaleSource
from fpnet_core.frozen import freeze_field, frozen_array
from fpnet_core.geometry import scale_of

Rings = tuple[Array, ...]


class DoorKind(StrEnum):
    """How a door opens."""

    SWING = 'swing'
    DOUBLE = 'double swing'
    SLIDING = 'sliding'
    FOLDING = 'folding'
    REVOLVING = 'revolving'
    OPENING = 'opening'  # no leaf at all
    UNKNOWN = 'unknown'


@dataclass(frozen=True, eq=False)
class ModelWall:
    """A wall or column seen from above: ``rings`` of (V, 2), ``source`` says who tells it."""

    rings: Rings
    probability: float = 1.0
    source: str = ''

    def __post_init__(self) -> None:
        """Check shapes and the probability."""
        _freeze_rings(self)
        _check_probability(self)


@dataclass(frozen=True, eq=False)
class ModelDoor:
    """
    A door.

    Parameters
    ----------
    ends : (2, 2)
        Of the opening, in the middle of the wall.
    depth_m : thickness of the wall that it is in; 0 where unknown
    kind : how it opens
    hinge : which of ``ends`` the leaf turns about; None where unknown or where it does not turn
    leaf : (2,)
        Where the leaf ends when it is open; None where unknown.
    name : as written in the file; empty if it has none
    probability, source : how surely it is there, and who tells it
    """

    ends: Array
    depth_m: float = 0.0
    kind: DoorKind = DoorKind.UNKNOWN
    hinge: int | None = None
    leaf: Array | None = None
    name: str = ''
    probability: float = 1.0
    source: str = ''

    def __post_init__(self) -> None:
        """Check shapes and ranges."""
        _freeze_opening(self)
        if self.leaf is not None:
            freeze_field(self, 'leaf', np.float64, (2,))
        if self.hinge not in (None, 0, 1):
            raise ValueError(f'ModelDoor.hinge: must be 0, 1 or None, got {self.hinge}')

    @property
    def width_m(self) -> float:
        """Length of the opening [m]."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))


@dataclass(frozen=True, eq=False)
class ModelWindow:
    """A window: ``ends (2, 2)`` in the middle of its wall, which is ``depth_m`` thick."""

    ends: Array
    depth_m: float = 0.0
    probability: float = 1.0
    source: str = ''

    def __post_init__(self) -> None:
        """Check shapes and ranges."""
        _freeze_opening(self)


@dataclass(frozen=True, eq=False)
class ModelRoom:
    """
    A room: its ``rings`` of (V, 2), and what the file has written in it.

    ``name`` is empty and ``printed_area_m2`` None where nothing is written; ``category`` is the
    file's own word for what the room is used for.
    """

    rings: Rings
    name: str = ''
    printed_area_m2: float | None = None
    category: str = ''
    probability: float = 1.0
    source: str = ''

    def __post_init__(self) -> None:
        """Check shapes and ranges."""
        _freeze_rings(self)
        _check_probability(self)
        area = self.printed_area_m2
        if area is not None and not 0.0 < area < math.inf:
            raise ValueError(f'ModelRoom.printed_area_m2: must be positive, got {area}')

    @property
    def area_m2(self) -> float:
        """Area within the first ring and outside of the others [m2]."""
        outside, *holes = (abs(ring_area(ring)) for ring in self.rings)
        return outside - sum(holes)


@dataclass(frozen=True)
class ModelStorey:
    """A storey of the building; ``elevation_m`` of its floor is None where nobody says it."""

    name: str
    elevation_m: float | None = None


@dataclass(frozen=True, eq=False)
class FloorplanModel:
    """
    What a drawing says of one storey.

    Parameters
    ----------
    walls, doors, windows, rooms : its elements; empty where the drawing tells none
    outline : rings of the building, the outside of its outer walls; empty where unknown
    storeys : all storeys of the building, from below
    storey : which one of them this is; None where unknown
    scale : what is known of the scale of the drawing's pixels; None where it has none
    H_plan_image : (3, 3)
        From the drawing's pixels to metres of frame ``plan``; None where there are no pixels.
    is_whole
        The file states the whole storey; if not, some doors only, and the rest is on its picture.
    """

    walls: tuple[ModelWall, ...] = ()
    doors: tuple[ModelDoor, ...] = ()
    windows: tuple[ModelWindow, ...] = ()
    rooms: tuple[ModelRoom, ...] = ()
    outline: Rings = ()
    storeys: tuple[ModelStorey, ...] = ()
    storey: int | None = None
    scale: DrawingScale | None = None
    H_plan_image: Array | None = None
    is_whole: bool = True

    def __post_init__(self) -> None:
        """Check shapes and that the storey is one of the storeys."""
        _freeze_rings(self, 'outline')
        if self.H_plan_image is not None:
            freeze_field(self, 'H_plan_image', np.float64, (3, 3))
        if self.storey is not None and not 0 <= self.storey < len(self.storeys):
            raise ValueError(
                f'FloorplanModel.storey: there are {len(self.storeys)} storeys, got {self.storey}'
            )

    @property
    def states_rooms(self) -> bool:
        """Tell whether the file states the storey's rooms, so that none need be found."""
        return self.is_whole and bool(self.rooms)

    @property
    def points(self) -> Array:
        """Every corner and end in it ``(N, 2)``."""
        rings = [ring for wall in self.walls for ring in wall.rings]
        rings += [ring for room in self.rooms for ring in room.rings]
        rings += [door.ends for door in self.doors] + [window.ends for window in self.windows]
        rings += self.outline
        return np.concatenate(rings) if rings else np.empty((0, 2))

    def moved(self, A: Array) -> FloorplanModel:
        """
        Return the model under an affine ``A (2, 3)`` that keeps angles, as to other units.

        Scale and ``H_plan_image`` are of the frame that is left, and not kept.
        """
        factor = float(scale_of(A[:, :2]))

        def move(points: Array) -> Array:
            moved: Array = points @ A[:, :2].T + A[:, 2]
            return moved

        def area(each: ModelWall | ModelRoom) -> Any:
            return replace(each, rings=tuple(map(move, each.rings)))

        return replace(
            self,
            walls=tuple(map(area, self.walls)),
            rooms=tuple(map(area, self.rooms)),
            doors=tuple(_moved_door(each, move, factor) for each in self.doors),
            windows=tuple(
                replace(each, ends=move(each.ends), depth_m=factor * each.depth_m)
                for each in self.windows
            ),
            outline=tuple(map(move, self.outline)),
            scale=None,
            H_plan_image=None,
        )


def _moved_door(door: ModelDoor, move: Callable[[Array], Array], factor: float) -> ModelDoor:
    leaf = None if door.leaf is None else move(door.leaf)
    return replace(door, ends=move(door.ends), leaf=leaf, depth_m=factor * door.depth_m)


def ring_area(ring: NDArray[np.float64]) -> float:
    """Return the area in a ring ``(V, 2)``, negative where it runs clockwise."""
    x, y = (ring - ring[0]).T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def _freeze_rings(owner: Any, name: str = 'rings') -> None:
    what = f'{type(owner).__name__}.{name}'
    rings = tuple(frozen_array(ring, np.float64, (None, 2), what) for ring in getattr(owner, name))
    if any(len(ring) < 3 for ring in rings) or (name == 'rings' and not rings):
        raise ValueError(f'{what}: expected rings of at least three corners')
    object.__setattr__(owner, name, rings)


def _freeze_opening(owner: Any) -> None:
    freeze_field(owner, 'ends', np.float64, (2, 2))
    _check_probability(owner)
    if not 0.0 <= owner.depth_m < math.inf:
        raise ValueError(f'{type(owner).__name__}.depth_m: must be 0 or more, got {owner.depth_m}')
    if not (owner.ends[0] != owner.ends[1]).any():
        raise ValueError(f'{type(owner).__name__}.ends: both are one place')


def _check_probability(owner: Any) -> None:
    if not 0.0 <= owner.probability <= 1.0:
        raise ValueError(
            f'{type(owner).__name__}.probability: must be in [0, 1], got {owner.probability}'
        )


_ELEMENTS = {
    'walls': ModelWall, 'doors': ModelDoor, 'windows': ModelWindow, 'rooms': ModelRoom,
}  # fmt: skip


def model_to_json(model: FloorplanModel) -> dict[str, Any]:
    """Return a model as plain values: lists, texts and numbers."""

    def plain(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return value.tolist()
        if isinstance(value, tuple):
            return [plain(each) for each in value]
        if hasattr(value, '__dataclass_fields__'):
            return {key: plain(getattr(value, key)) for key in value.__dataclass_fields__}
        return value.value if isinstance(value, StrEnum) else value

    result: dict[str, Any] = plain(model)
    return result


def model_from_json(values: dict[str, Any]) -> FloorplanModel:
    """
    Return the model of plain values as :func:`model_to_json` makes them.

    Raises
    ------
    ValueError, KeyError, TypeError
        If they are others.
    """
    values = dict(values)
    for name, kind in _ELEMENTS.items():
        values[name] = tuple(kind(**_arrays(each)) for each in values[name])
    values['outline'] = tuple(map(np.array, values['outline']))
    values['storeys'] = tuple(ModelStorey(**each) for each in values['storeys'])
    if values['scale'] is not None:
        source = ScaleSource(values['scale']['source'])
        values['scale'] = DrawingScale(**{**values['scale'], 'source': source})
    return FloorplanModel(**values)


def _arrays(values: dict[str, Any]) -> dict[str, Any]:
    values = dict(values)
    if 'rings' in values:
        values['rings'] = tuple(map(np.array, values['rings']))
    if 'kind' in values:
        values['kind'] = DoorKind(values['kind'])
    return values
