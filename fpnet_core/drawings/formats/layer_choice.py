# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Selection of the layers of a vector drawing that hold walls, by their names and contents.

Walls are long straight strokes with a parallel one at a wall's thickness beside them. A layer
with most of those is kept whatever its name.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.formats.layers import LayerRole, is_symbols, layer_role
from fpnet_core.drawings.formats.pages import Array, OutlinePieces, VectorPage
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import MapFormatError

# Chosen, not measured:
_LONG = 0.015  # of the drawing's long side: shortest stroke of a wall, 0.75 m of 50 m
_THICK = (0.001, 0.025)  # of the long side: distance between the two faces of a wall
_ALIKE = np.radians(3.0)  # largest angle between parallel faces
_SINGLE = 0.2  # weight of a stroke without a parallel face beside it
_SPAN = 0.85  # of the drawing's width or height that a frame spans
_NAMED = 0.25  # of the walls' strokes, from which layers named after walls are used alone
_MOST = 0.5  # of the walls' strokes, from which a layer is kept whatever its name
_MOST_OF_SYMBOLS = 0.9  # the same for layers named after furniture, texts or titles
_SAMPLES = 60_000  # numerical: points along strokes that are compared
_NEIGHBOURS = 6  # numerical: neighbours of each point that are compared
_LIST = 6  # numerical: layers named in a message
_WHITE = 250  # smallest level of red, green and blue in the colour of paper


@dataclass(frozen=True, eq=False)
class Choice:
    """Selection of painted paths ``is_path (P,)``, and the reasons in ``notes``."""

    is_path: NDArray[np.bool_]
    notes: tuple[str, ...] = ()


def is_seen(page: VectorPage) -> NDArray[np.bool_]:
    """Return the mask of paths with a colour that is visible on white paper."""
    seen = np.zeros(len(page.width), dtype=np.bool_)
    for colour in (page.fill, page.stroke):
        seen |= (colour[:, 3] > 0) & (colour[:, :3] < _WHITE).any(axis=1)
    return seen


def choose_paths(
    page: VectorPage, pieces: OutlinePieces, is_hatch: NDArray[np.bool_], options: ReadOptions
) -> Choice:
    """
    Return which paths are painted: the layers named by the user, else those that hold walls.

    If layers named after walls hold a fair share of what looks like walls, only these are painted;
    else all that are not known to be something else. Dashed lines and segments of hatches
    ``is_hatch (N,)`` are never walls.

    Raises
    ------
    MapFormatError
        If the drawing has none of the layers in ``options``.
    """
    solid = ~page.is_dashed
    if options.layers:
        return Choice(_requested(page, options)[page.layer] & solid)
    roles = np.array([layer_role(layer) for layer in page.layers], dtype=object)
    is_symbol = np.array([is_symbols(layer) for layer in page.layers])
    share = _wall_share(page, pieces, is_hatch, is_symbol)
    is_wall, is_window = roles == LayerRole.WALL, roles == LayerRole.WINDOW
    is_unknown = roles == LayerRole.UNKNOWN
    most = np.where(is_symbol, _MOST_OF_SYMBOLS, _MOST)
    is_rescued = ~(is_wall | is_window | is_unknown) & (share >= most)
    if share[is_wall].sum() >= _NAMED * share[is_wall | is_unknown | is_rescued].sum() > 0.0:
        kept = is_wall | is_window
        notes = [f'walls are on {_listed(page.layers, kept)}']
        if is_unknown.any():
            notes.append(f'left out because of unknown names: {_listed(page.layers, is_unknown)}')
        return Choice(kept[page.layer] & solid, tuple(notes))
    kept = is_wall | is_window | is_unknown | is_rescued
    if not share[kept].any():
        kept = ~is_symbol if share[~is_symbol].any() else np.ones_like(kept)
    notes = []
    if len(page.layers) > 1 and is_rescued.any():
        notes.append(f'kept for its walls despite its name: {_listed(page.layers, is_rescued)}')
    if len(page.layers) > 1 and not kept.all():
        notes.append(f'left out: {_listed(page.layers, ~kept)}')
    return Choice(kept[page.layer] & solid, tuple(notes))


def _requested(page: VectorPage, options: ReadOptions) -> NDArray[np.bool_]:
    """Return the mask of the layers named by the user, with the blocks on them."""
    wanted = {layer.casefold() for layer in options.layers}
    chosen = np.array([
        layer.casefold() in wanted or layer.casefold().partition(': ')[0] in wanted
        for layer in page.layers
    ])  # fmt: skip
    if not chosen.any():
        every = np.ones_like(chosen)
        raise MapFormatError(
            f'no layer {", ".join(options.layers)} in this drawing; '
            f'it has {_listed(page.layers, every)}'
        )
    return chosen


def _wall_share(
    page: VectorPage,
    pieces: OutlinePieces,
    is_hatch: NDArray[np.bool_],
    is_symbol: NDArray[np.bool_],
) -> NDArray[np.float64]:
    """
    Return each layer's share of what looks like walls ``(L,)``, by length of strokes.

    All zero if nothing does. Strokes that span the drawing on a layer of symbols are a frame, not
    a wall.
    """
    layer, count = page.layer[pieces.path], len(page.layers)
    seen = (is_seen(page) & ~page.is_dashed)[pieces.path] & ~pieces.is_curve & ~is_hatch
    if not seen.any():
        return np.zeros(count)
    points = pieces.ends[seen].reshape(-1, 2)
    low, high = np.percentile(points, (1, 99), axis=0)
    size = float(max(high - low)) or 1.0
    spans = np.abs(pieces.ends[:, 1] - pieces.ends[:, 0]) > _SPAN * np.maximum(high - low, 1e-12)
    is_frame = spans.any(axis=1) & is_symbol[layer]
    chosen = np.flatnonzero(seen & ~is_frame & (pieces.length > _LONG * size))
    if not len(chosen):
        return _normal(np.bincount(layer[seen], pieces.length[seen], count))
    ends, length = pieces.ends[chosen], pieces.length[chosen]
    faced = _faced(ends, length, size)
    width = page.width[pieces.path[chosen]] * (page.stroke[pieces.path[chosen], 3] > 0)
    faced[(width > _THICK[0] * size) & (width < _THICK[1] * size)] = 1.0
    weight = length * (_SINGLE + (1.0 - _SINGLE) * faced)
    return _normal(np.bincount(layer[chosen], weight, count))


def _normal(weight: NDArray[Any]) -> NDArray[np.float64]:
    return weight / max(float(weight.sum()), 1e-12)


def _faced(ends: Array, length: Array, size: float) -> NDArray[np.float64]:
    """Return the share of each stroke ``(N,)`` that has a parallel one at a wall's thickness."""
    from scipy.spatial import cKDTree

    step = max(0.5 * _LONG * size, float(length.sum()) / _SAMPLES)
    number = np.maximum(length / step, 1.0).astype(np.int64)
    stroke = np.repeat(np.arange(len(ends)), number)
    rank = np.arange(len(stroke)) - np.repeat(np.cumsum(number) - number, number)
    direction = (ends[:, 1] - ends[:, 0]) / length[:, None]
    along = (rank + 0.5) * (length / number)[stroke]
    places = ends[stroke, 0] + along[:, None] * direction[stroke]
    # The doubled angle does not depend on the direction of a stroke.
    doubled = 2.0 * np.arctan2(direction[:, 1], direction[:, 0])
    reach = _THICK[1] * size
    turn = 0.5 * reach / _ALIKE * np.column_stack([np.cos(doubled), np.sin(doubled)])
    features = np.hstack([places, turn[stroke]])
    far = float(np.hypot(reach, 0.5 * step))
    _, near = cKDTree(features).query(features, k=_NEIGHBOURS, distance_upper_bound=far)
    is_there = near < len(stroke)
    other = np.where(is_there, near, 0)
    offset = places[other] - places[:, None]
    normal = np.column_stack([-direction[:, 1], direction[:, 0]])[stroke]
    apart = np.abs(np.einsum('pkc,pc->pk', offset, normal))
    beside = is_there & (stroke[other] != stroke[:, None])
    beside &= (apart > _THICK[0] * size) & (apart < reach)
    found = np.bincount(stroke, beside.any(axis=1), len(ends))
    share: NDArray[np.float64] = found / number
    return share


def _listed(layers: tuple[str, ...], is_named: NDArray[np.bool_]) -> str:
    """Return names of layers for a message."""
    named = [layers[k] for k in np.flatnonzero(is_named)]
    shown = ', '.join(layer or '(no name)' for layer in named[:_LIST])
    return f'{shown} and {len(named) - _LIST} more' if len(named) > _LIST else shown
