# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Scale estimation of drawings from their doors, rooms and walls.

The set holds the real floorplans of both splits, bare and furnished, and generated storeys, homes
and large houses in many styles. Their scale is known, but the estimator does not get it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
import time
from typing import Any

import numpy as np

from fpnet_core.config import SegmentationConfig
from fpnet_core.errors import FpnetError
from fpnet_core.io.maps import read_map
from fpnet_core.segmentation import segment_unknown_scale
from fpnet_core.types import GridMap
from fpnet_lab.metrics.intervals import interval_figures
from fpnet_lab.sim.drawn.styled import HOMES, HOUSES, PRACTICES, STOREYS, styled_drawing
from fpnet_lab.sim.pairs.presets import SPLITS
from fpnet_lab.sim.population.floors import CELL_M

SEED = 7001
"""Numerical: seed of the generated sheets; different from all training seeds."""

_GENERATED = {'generated': STOREYS, 'homes': HOMES, 'practices': PRACTICES, 'houses': HOUSES}
_IMAGES = {'bare': 'floorplan/{}.png', 'furnished': 'furnished/{}_furnitures.png'}


def count_drawings(generated: int) -> int:
    """Count the drawings of :func:`bench_scale`."""
    return len(_IMAGES) * sum(map(len, SPLITS.values())) + len(_GENERATED) * generated


def bench_scale(
    data: Path,
    generated: int,
    config: SegmentationConfig,
    on_drawing: Callable[[float], None] = lambda _: None,
) -> dict[str, Any]:
    """
    Estimate the scale of real drawings and of ``generated`` drawings of each kind.

    Returns
    -------
    The figures of :func:`interval_figures` by group, with ``ms_per_drawing`` for rooms and scale
    together; ``drawings`` lists the estimates as factors of the true scale.

    Raises
    ------
    FpnetError
        If a floorplan is missing.
    """
    rows: list[dict[str, Any]] = []
    for group, name, grid in _drawings(data, generated):
        started = time.perf_counter()
        _, estimate = segment_unknown_scale(grid, config)
        elapsed_ms = round(1e3 * (time.perf_counter() - started), 1)
        over_truth = {key: round(value, 4) for key, value in vars(estimate).items()}
        rows.append({'group': group, 'name': name, **over_truth, 'ms': elapsed_ms})
        on_drawing(1.0)
    groups = dict.fromkeys(row['group'] for row in rows)
    return {'groups': {group: _figures(rows, group) for group in groups}, 'drawings': rows}


def _figures(rows: list[dict[str, Any]], group: str) -> dict[str, float]:
    of_group = [row for row in rows if row['group'] == group]
    errors = np.log([[row['low'], row['factor'], row['high']] for row in of_group])
    ms = round(float(np.median([row['ms'] for row in of_group])), 1)
    return interval_figures(errors) | {'ms_per_drawing': ms}


def _drawings(data: Path, generated: int) -> Iterator[tuple[str, str, GridMap]]:
    """Yield group, name and drawing, whose resolution is the true one."""
    for split, names in SPLITS.items():
        for kind, image in _IMAGES.items():
            for name in names:
                path = data / 'bormann' / image.format(name)
                if not path.is_file() and kind == 'furnished':
                    continue  # some storeys have no furnished version
                if not path.is_file():
                    raise FpnetError(f'{path} is missing; give the folder of the shared data')
                yield f'{split} {kind}', name, read_map(path, CELL_M)
    for group, source in _GENERATED.items():
        for number in range(generated):
            rng = np.random.default_rng([SEED, number])
            yield group, str(number), styled_drawing(rng, source)
