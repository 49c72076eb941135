# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Accuracy of the parser network on held-out sheets."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.parsing.network import parse
from fpnet_core.drawings.pictures.building import BUILDING_PX, SHEET_PX, WALL_PX
from fpnet_core.drawings.types import Chances
from fpnet_core.io.pixel_classes import CLASSES
from fpnet_lab.sim.sheets import SheetKind
from fpnet_lab.training.parser_samples import Sample, sheet_sample
from fpnet_lab.training.parser_views import shrunk

HELD_SEED = 3_000_000
"""Numerical: seed of the first held-out sheet; training seeds are larger."""

_CLASS_BITS = 0b111  # given


def held_figures(network: Any, count: int) -> dict[str, dict[str, float]]:
    """
    Return the intersection over union of each class, by kind of sheet and ``all``.

    ``network`` is from :func:`fpnet_core.drawings.parsing.network.network_from`; ``count`` sheets
    of each kind are parsed as drawings are: as a whole, then at the resolution that walls need.
    """
    size = len(CLASSES)
    tables: dict[str, NDArray[np.int64]] = defaultdict(lambda: np.zeros((size, size), np.int64))
    for kind in SheetKind:
        for number in range(count):
            table = _table(network, sheet_sample(HELD_SEED + number, kind))
            for name in (kind.value, 'all'):
                tables[name] = tables[name] + table
    return {name: _overlaps(table) for name, table in sorted(tables.items())}


def _table(network: Any, sample: Sample) -> NDArray[np.int64]:
    """Return the confusion matrix of the last pass: true classes in rows, output in columns."""
    longest = max(sample.classes.shape)
    wanted = sample.building_px * WALL_PX / max(sample.wall_px, 1.0)
    last = float(np.clip(wanted, *BUILDING_PX)) / sample.building_px
    seen: Chances | None = None
    for factor in (*(px / longest for px in SHEET_PX), last):
        pixels, true = _sized(sample, factor)
        context = None if seen is None else _known(seen, true.shape)
        seen = parse(pixels, context, network).chances
    assert seen is not None
    pairs = len(CLASSES) * true.ravel().astype(np.int64) + seen.argmax(axis=0).ravel()
    return np.bincount(pairs, minlength=len(CLASSES) ** 2).reshape(2 * [len(CLASSES)])


def _known(seen: Chances, shape: tuple[int, ...]) -> Chances:
    """Return an earlier pass's output as context (CONTEXT, H, W), resized to ``shape``."""
    known = [*seen, np.ones(seen.shape[1:], np.float32)]
    return np.stack([np.asarray(cv2.resize(c, shape[::-1]), np.float32) for c in known])


def _sized(sample: Sample, factor: float) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return pixels and classes of a smaller image; images are not enlarged."""
    height, width = sample.classes.shape
    factor = min(1.0, factor)
    size = (max(1, round(factor * width)), max(1, round(factor * height)))
    pixels, answers = shrunk(sample, size)
    return pixels, np.asarray(answers & _CLASS_BITS, np.uint8)


def _overlaps(table: NDArray[np.int64]) -> dict[str, float]:
    both = np.diag(table)
    either = table.sum(axis=0) + table.sum(axis=1) - both
    shares = both / np.maximum(either, 1)
    return {name: round(float(share), 4) for name, share in zip(CLASSES, shares, strict=True)}
