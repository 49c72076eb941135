# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Parser warnings: whether a parse is right; if not, why, where on the drawing, and what to do.

Features of a room from the class probabilities of its pixels give the probability that the room
is right. All rooms together give the probabilities that the parse is wrong, and that the image
shows no building. The logistic regressions are fitted by ``fpnet train doubts``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
import json
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.building import SeenBuilding, first_cells
from fpnet_core.drawings.pictures.hypothesis import PlanHypothesis, rooms_of, stride
from fpnet_core.drawings.pictures.plausible import FEATURES, features, findings
from fpnet_core.drawings.pictures.spaces import LIKELY, SURELY
from fpnet_core.drawings.types import Box, Chances, Doubtful
from fpnet_core.errors import WeightsError
from fpnet_core.io.pixel_classes import DOOR, FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_core.raster.morphology import grown, shrunk
from fpnet_core.raster.pixels import map_points
from fpnet_core.raster.windows import EVERY_SIDE
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.small_networks import standardised
from fpnet_core.types import FREE, OCCUPIED, UNKNOWN, Segmentation

Array = NDArray[np.float64]
Labels = NDArray[np.int32]

DOUBTS_NAME = 'doubts.json'

ROOM_FIGURES = (
    'size', 'square', 'solid', 'doors', 'floor', 'first_floor', 'outside', 'walled', 'open',
    'overlooked', 'other', 'log_rooms',
)  # fmt: skip
SHEET_FIGURES = (
    'right', 'least_right', 'doubtful', 'certainty', 'walls', 'unsure', 'agreement', 'lost',
    *FEATURES,
)  # fmt: skip

# Chosen, not measured:
_INNER_CELLS = 2  # distance from the walls at which a room's interior begins
_LINE_CELLS = 4  # lines are this much thicker in the coarse pass
_MOST_MARKED = 12  # largest number of marked regions
_SIDE = 1.0 / 3.0  # of the building's extent is its left, right, top or bottom
_LEAST = 0.02  # numerical: smallest probability, so that log odds are finite

_PLACES = {'': 'in the middle', 'upper': 'at the top', 'lower': 'at the bottom'}

_CAUSES = {
    'open': (
        'open to the outside: a wall has a wide gap or was not detected',
        'draw that wall in an image editor',
    ),
    'unsure': (
        'uncertain: the network has low confidence in their floor or walls',
        'use a drawing without furniture, stairs and arrows',
    ),
    'coarse_pass': ('segmented differently by the coarse pass', 'compare them with the drawing'),
}


@dataclass(frozen=True, eq=False)
class SheetEvidence:
    """Features of ``rooms (R, D)``, as in ``ROOM_FIGURES``, and of the ``whole (F,)`` sheet."""

    rooms: Array
    whole: Array


@dataclass(frozen=True)
class Doubts:
    """
    Parser warnings of a building.

    ``wrong`` is the probability of a wrong parse; ``reasons`` are the warnings, one sentence each,
    and ``places`` their regions on the drawing. ``is_other`` is true if the image seems to show
    something other than a building.
    """

    wrong: float
    reasons: tuple[str, ...] = ()
    places: tuple[Doubtful, ...] = ()
    is_other: bool = False


@dataclass(frozen=True, eq=False)
class Regression:
    """A logistic regression with ``mean``, ``spread``, ``weight (D,)`` and ``bias``."""

    mean: Array
    spread: Array
    weight: Array
    bias: float

    def __call__(self, figures: Array) -> Array:
        """Return the probability (N,) for features ``figures (N, D)``."""
        return np.asarray(
            expit(standardised(figures, self.mean, self.spread) @ self.weight + self.bias)
        )

    @classmethod
    def of(cls, stored: dict[str, Any], names: Sequence[str]) -> Regression:
        """Return the regression of a file; WeightsError if it was fitted to other features."""
        if stored['figures'] != list(names):
            raise WeightsError(
                f'{DOUBTS_NAME}: fitted to other features; fit it again with fpnet train doubts'
            )
        mean, spread, weight = (np.array(stored[key]) for key in ('mean', 'spread', 'weight'))
        return cls(mean, spread, weight, float(stored['bias']))


@dataclass(frozen=True, eq=False)
class DoubtModel:
    """
    Regressions for right rooms, wrong parses, and images of something other than buildings.

    ``doubted_from`` and ``other_from`` are the probabilities from which warnings are given.
    """

    right_room: Regression
    wrong_sheet: Regression
    other_picture: Regression
    doubted_from: float
    other_from: float

    def right_rooms(self, evidence: SheetEvidence) -> Array:
        """Return the probability (R,) that each room is right."""
        return self.right_room(evidence.rooms)

    def wrong(self, evidence: SheetEvidence) -> float:
        """Return the probability that a parse is wrong."""
        figures = sheet_figures(evidence, self.right_rooms(evidence))
        return float(self.wrong_sheet(figures[None])[0])

    def other(self, evidence: SheetEvidence) -> float:
        """Return the probability that an image shows something other than a building."""
        figures = sheet_figures(evidence, self.right_rooms(evidence))
        return float(self.other_picture(figures[None])[0])


@cache
def packaged_doubt_model() -> DoubtModel:
    """Return the packaged model, read once."""
    file = resources.files('fpnet_core.weights') / DOUBTS_NAME
    return model_of(json.loads(file.read_text(encoding='utf-8')))


def model_of(stored: dict[str, Any]) -> DoubtModel:
    """Return the model of a file; WeightsError if it was fitted to other features."""
    return DoubtModel(
        Regression.of(stored['rooms'], ROOM_FIGURES),
        Regression.of(stored['sheets'], SHEET_FIGURES),
        Regression.of(stored['others'], SHEET_FIGURES),
        float(stored['doubted_from']),
        float(stored['other_from']),
    )


def evidence_of(found: PlanHypothesis, config: SegmentationConfig) -> SheetEvidence:
    """Return the features of a building that the network found, with at least one room."""
    rooms, seen = found.segmentation, found.seen
    assert seen is not None, 'a robot map has no network output'
    first, _ = rooms_of(_first_cells(found, seen), config, found.known_factor, found.prior)
    chances, before = (_at_cells(each, found) for each in (seen.chances, seen.first_chances))
    columns = {
        **_shapes(rooms),
        **_surfaces(rooms, chances, before),
        **_edges(rooms, chances),
        'other': best_overlap(rooms.labels, first.labels, len(rooms.rooms)),
        'log_rooms': np.full(len(rooms.rooms), np.log(len(rooms.rooms))),
    }
    built = rooms.grid.cells != UNKNOWN
    most = chances.max(axis=0)[built]
    walls = rooms.grid.cells == OCCUPIED
    inside = 1.0 - chances[OUTSIDE]
    whole = [
        float(most.mean()),
        float((chances[WALL] + chances[WINDOW])[walls].mean()) if walls.any() else 0.0,
        float((most < SURELY).mean()),
        room_agreement(first.labels, rooms.labels).f1,
        float(inside[~built].sum() / max(int(built.sum()), 1)),
        *features(rooms).tolist(),
    ]
    of_rooms = np.column_stack([columns[name] for name in ROOM_FIGURES])
    return SheetEvidence(of_rooms, np.array(whole))


def _first_cells(found: PlanHypothesis, seen: SeenBuilding) -> NDArray[np.int8]:
    """Return the cells (H, W) of the coarse pass, without the thin lines that were removed."""
    cells = first_cells(seen)
    gone = grown((seen.cells == OCCUPIED) & (found.cells == FREE), _LINE_CELLS)
    return np.where(gone & (cells == OCCUPIED), FREE, cells).astype(np.int8)


def sheet_figures(evidence: SheetEvidence, right: Array) -> Array:
    """Return the features (F,) of a building whose rooms have probabilities ``right (R,)``."""
    held = np.clip(right, _LEAST, 1.0 - _LEAST)
    odds = np.log(held / (1.0 - held))
    of_rooms = [odds.mean(), np.quantile(odds, 0.1), np.mean(right < LIKELY)]
    return np.array([*of_rooms, *evidence.whole])


def doubts_of(found: PlanHypothesis, config: SegmentationConfig) -> Doubts:
    """Return the parser warnings of a building."""
    rooms = found.segmentation
    if not rooms.rooms:
        why = f'No room was found: {rooms.reason or "nothing is enclosed"}.'
        return Doubts(1.0, (why,), is_other=found.known_factor is None)
    absurd = findings(rooms)
    if found.seen is None:
        return Doubts(0.0, tuple(absurd))
    model, evidence = packaged_doubt_model(), evidence_of(found, config)
    wrong, other = model.wrong(evidence), model.other(evidence)
    if other > model.other_from:
        summary = f'It seems to show something other than a floorplan (probability {other:.2f}).'
        return Doubts(wrong, (summary, *absurd), is_other=True)
    if wrong <= model.doubted_from:
        return Doubts(wrong, tuple(absurd))
    places = tuple(_places(found, evidence, model.right_rooms(evidence)))
    reasons = (*absurd, *_sentences(places, found))
    summary = f'The rooms are implausible for a building (probability of an error {wrong:.2f}).'
    return Doubts(wrong, reasons or (summary,), places[:_MOST_MARKED])


def _at_cells(chances: Chances, found: PlanHypothesis) -> Chances:
    """Return the probabilities (K, H, W) at the cells of the segmentation, row 0 lowest."""
    step = stride(found.cells)
    rows, cols = found.segmentation.grid.shape
    padded = np.zeros((len(chances), rows * step, cols * step), np.float32)
    padded[OUTSIDE] = 1.0
    padded[:, : chances.shape[1], : chances.shape[2]] = chances
    if step > 1:
        padded = np.stack(
            [cv2.resize(c, (cols, rows), interpolation=cv2.INTER_AREA) for c in padded]
        )
    return np.ascontiguousarray(padded[:, ::-1])


def _shapes(rooms: Segmentation) -> dict[str, Array]:
    area = np.array([room.area_m2 for room in rooms.rooms])
    square, solid = np.zeros(len(area)), np.zeros(len(area))
    for number, room in enumerate(rooms.rooms):
        ring = room.polygon.astype(np.float32)
        _, (long, short), _ = cv2.minAreaRect(ring)
        square[number] = area[number] / max(long * short, 1e-6)
        solid[number] = area[number] / max(cv2.contourArea(cv2.convexHull(ring)), 1e-6)
    doors = np.zeros(len(area))
    for portal in rooms.portals:
        for joined in portal.rooms:
            if joined is not None and joined < len(area):
                doors[joined] += 1.0
    return {
        'size': np.log(area / np.median(area)),
        'square': square,
        'solid': solid,
        'doors': np.log1p(doors),
    }


def _surfaces(rooms: Segmentation, chances: Chances, before: Chances) -> dict[str, Array]:
    """Return features of the class probabilities inside rooms."""
    labels, count = rooms.labels, len(rooms.rooms)
    inner = labels * shrunk(labels > 0, _INNER_CELLS)

    def mean(values: NDArray[np.float32], at: Labels) -> Array:
        size = np.bincount(at.ravel(), minlength=count + 1)[1 : count + 1]
        total = np.bincount(at.ravel(), values.ravel(), count + 1)[1 : count + 1]
        return np.asarray(total / np.maximum(size, 1))

    return {
        'floor': mean(chances[FLOOR] + chances[DOOR], labels),
        'first_floor': mean(before[FLOOR] + before[DOOR], labels),
        'outside': mean(chances[OUTSIDE], labels),
        'overlooked': mean(chances[WALL], inner),
    }


def _edges(rooms: Segmentation, chances: Chances) -> dict[str, Array]:
    """Return features of room boundaries: probability of walls, and share without a wall."""
    cells, labels, count = rooms.grid.cells, rooms.labels, len(rooms.rooms)
    solid = chances[WALL] + chances[WINDOW]
    ends, walled, bare = np.zeros(count + 1), np.zeros(count + 1), np.zeros(count + 1)
    for here, there in EVERY_SIDE:
        room = labels[here]
        edge = (room > 0) & (labels[there] != room)
        at = room[edge]
        is_wall = cells[there][edge] == OCCUPIED
        ends += np.bincount(at[is_wall], minlength=count + 1)
        walled += np.bincount(at[is_wall], solid[there][edge][is_wall], count + 1)
        bare += np.bincount(at, cells[there][edge] == UNKNOWN, count + 1)
    all_ends = np.maximum(ends + bare, 1.0)
    return {'walled': walled[1:] / np.maximum(ends[1:], 1.0), 'open': (bare / all_ends)[1:]}


def best_overlap(labels: Labels, others: Labels, count: int) -> Array:
    """Return the best intersection over union (count,) of each room with one of ``others``."""
    width = int(others.max(initial=0)) + 1
    pairs = labels.ravel().astype(np.int64) * width + others.ravel()
    both = np.bincount(pairs, minlength=(count + 1) * width).reshape(-1, width)
    if width < 2:
        return np.zeros(count)
    shares = both / np.maximum(both.sum(axis=1, keepdims=True) + both.sum(axis=0) - both, 1)
    return np.asarray(shares[1 : count + 1, 1:].max(axis=1))


def _places(found: PlanHypothesis, evidence: SheetEvidence, right: Array) -> Iterator[Doubtful]:
    """Yield the doubtful rooms on the drawing, the least probable first."""
    for number in np.argsort(right):
        if right[number] < LIKELY:
            figures = dict(zip(ROOM_FIGURES, evidence.rooms[number].tolist(), strict=True))
            strength = {
                'open': figures['open'],
                'unsure': 2.0 - figures['floor'] - figures['walled'],
                'coarse_pass': 1.0 - figures['other'],
            }
            cause = max(strength, key=lambda name: strength[name])
            yield Doubtful(cause, _box(found, found.segmentation.rooms[number].polygon))


def _box(found: PlanHypothesis, xy: Array) -> Box:
    """Return the box in the drawing's pixels around points (N, 2) of the plan."""
    low, high = xy.min(axis=0), xy.max(axis=0)
    corners = np.array([low, [low[0], high[1]], high, [high[0], low[1]]])
    pixels = map_points(np.asarray(np.linalg.inv(found.H_plan_pixel), np.float64), corners)
    first, last = np.floor(pixels.min(axis=0)), np.ceil(pixels.max(axis=0))
    return int(first[0]), int(first[1]), int(last[0]), int(last[1])


def _sentences(places: Sequence[Doubtful], found: PlanHypothesis) -> Iterator[str]:
    """Yield one sentence per cause: number of rooms, location, reason and remedy."""
    whole = _box(found, np.concatenate([room.polygon for room in found.segmentation.rooms]))
    for name, (why, remedy) in _CAUSES.items():
        boxes = [place.box for place in places if place.what == name]
        if boxes:
            many = f'{len(boxes)} rooms are' if len(boxes) > 1 else 'A room is'
            yield f'{many} {why} ({" and ".join(_where(boxes, whole))}): {remedy}.'


def _where(boxes: Sequence[Box], whole: Box) -> list[str]:
    """Return the parts of the building with the most boxes, at most two."""
    named: dict[str, int] = {}
    left, top, right, bottom = whole
    for box in boxes:
        x = ((box[0] + box[2]) / 2.0 - left) / max(right - left, 1)
        y = ((box[1] + box[3]) / 2.0 - top) / max(bottom - top, 1)
        words = [
            *(['upper'] if y < _SIDE else ['lower'] if y > 1.0 - _SIDE else []),
            *(['left'] if x < _SIDE else ['right'] if x > 1.0 - _SIDE else []),
        ]
        name = _PLACES.get(' '.join(words), f'at the {" ".join(words)}')
        named[name] = named.get(name, 0) + 1
    return sorted(named, key=lambda name: -named[name])[:2]
