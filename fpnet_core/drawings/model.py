# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Vector model of one storey: walls, doors, windows and rooms.

Coordinates are metres in frame ``plan`` (x right, y up) unless a reader states otherwise. Rings
are corner sequences, not closed; the first ring of an area is its exterior, others are holes.
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
    """Type of a door by how it opens."""

    SWING = 'swing'
    DOUBLE = 'double swing'
    SLIDING = 'sliding'
    FOLDING = 'folding'
    REVOLVING = 'revolving'
    OPENING = 'opening'  # without a leaf
    UNKNOWN = 'unknown'


@dataclass(frozen=True, eq=False)
class ModelWall:
    """Footprint of a wall or column: ``rings`` of (V, 2); ``source`` is the element's origin."""

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
        End points of the opening on the centre line of the wall.
    depth_m : thickness of the surrounding wall; 0 if unknown
    kind : type of the door
    hinge : index into ``ends`` of the hinge; None if unknown or without a swinging leaf
    leaf : (2,)
        Tip of the open leaf; None if unknown.
    name : as written in the file; empty if it has none
    probability, source : probability that the door exists, and origin of the element
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
    """A window: ``ends (2, 2)`` on the centre line of its wall, which is ``depth_m`` thick."""

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
    A room: ``rings`` of (V, 2) and the texts that the file has in it.

    ``name`` is empty and ``printed_area_m2`` None without such a text; ``category`` is the room's
    use as named in the file.
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
        """Area of the first ring minus the holes [m2]."""
        outside, *holes = (abs(ring_area(ring)) for ring in self.rings)
        return outside - sum(holes)


@dataclass(frozen=True)
class ModelStorey:
    """A storey of the building; ``elevation_m`` of its floor is None if not stated."""

    name: str
    elevation_m: float | None = None


@dataclass(frozen=True, eq=False)
class FloorplanModel:
    """
    Elements of one storey as stated by a drawing.

    Parameters
    ----------
    walls, doors, windows, rooms : elements; empty if the drawing states none
    outline : rings along the exterior of the outer walls; empty if unknown
    storeys : all storeys of the building, lowest first
    storey : index of this one in ``storeys``; None if unknown
    scale : scale of the drawing's pixels; None if not known
    H_plan_image : (3, 3)
        Maps pixels of the drawing to metres of frame ``plan``; None without pixels.
    is_whole
        If false, the file states some doors only, and the rest must be parsed from its image.
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
        """Whether the file states the storey's rooms, so that no segmentation is needed."""
        return self.is_whole and bool(self.rooms)

    @property
    def points(self) -> Array:
        """All corners and end points ``(N, 2)``."""
        rings = [ring for wall in self.walls for ring in wall.rings]
        rings += [ring for room in self.rooms for ring in room.rings]
        rings += [door.ends for door in self.doors] + [window.ends for window in self.windows]
        rings += self.outline
        return np.concatenate(rings) if rings else np.empty((0, 2))

    def moved(self, A: Array) -> FloorplanModel:
        """
        Return the model transformed by a similarity ``A (2, 3)``, e.g. to other units.

        ``scale`` and ``H_plan_image`` refer to the old frame and are set to None.
        """

        def move(points: Array) -> Array:
            moved: Array = points @ A[:, :2].T + A[:, 2]
            return moved

        return self.mapped(move, float(scale_of(A[:, :2])))

    def mapped(self, move: Callable[[Array], Array], factor: float) -> FloorplanModel:
        """
        Return the model with points ``(N, 2)`` mapped by ``move`` and thicknesses by ``factor``.

        ``scale`` and ``H_plan_image`` refer to the old frame and are set to None.
        """

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
    """Return the signed area of a ring ``(V, 2)``, negative if clockwise."""
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
        raise ValueError(f'{type(owner).__name__}.ends: the two ends coincide')


def _check_probability(owner: Any) -> None:
    if not 0.0 <= owner.probability <= 1.0:
        raise ValueError(
            f'{type(owner).__name__}.probability: must be in [0, 1], got {owner.probability}'
        )


_ELEMENTS = {
    'walls': ModelWall, 'doors': ModelDoor, 'windows': ModelWindow, 'rooms': ModelRoom,
}  # fmt: skip


def model_to_json(model: FloorplanModel) -> dict[str, Any]:
    """Return a model as JSON values: lists, strings and numbers."""

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
    Return the model from the output of :func:`model_to_json`.

    Raises
    ------
    ValueError, KeyError, TypeError
        If the values do not describe a model.
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
