# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fitting what weighs the readings of a drawing, on readings whose truth is known."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import GroupKFold, cross_val_predict

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.formats.images import open_image
from fpnet_core.drawings.pictures.choosing import all_readings
from fpnet_core.drawings.pictures.plausible import FEATURES, features, powers
from fpnet_core.drawings.types import ReadOptions
from fpnet_core.errors import FpnetError
from fpnet_core.raster.pixels import map_points
from fpnet_core.segmentation.agreement import room_agreement
from fpnet_core.types import GridMap
from fpnet_lab.evaluation.drawings import GOOD_F1
from fpnet_lab.sim.population.floors import TUNE_FLOORS, read_labels

Array = NDArray[np.float64]

_STRENGTH = 0.3  # inverse of the ridge that keeps the weights of rare figures small; chosen
_FOLDS = 5  # numerical
_MAX_ITERATIONS = 2000  # numerical


@dataclass(frozen=True, eq=False)
class LabelledDrawing:
    """
    A drawing's pixels (H, W, 3) and its true rooms.

    ``rooms`` are labels (H, W), 0 outside, once for each way to take the storeys of a sheet.
    """

    name: str
    pixels: NDArray[np.uint8]
    rooms: tuple[NDArray[np.int32], ...]


def labelled_sheets(folder: Path) -> Iterator[LabelledDrawing]:
    """
    Yield the sheets in ``folder``, each in a folder as ``fpnet simulate sheet`` writes it.

    Raises
    ------
    FpnetError
        If there are none.
    """
    paths = sorted(folder.glob('*/truth.json'))
    if not paths:
        raise FpnetError(f'{folder} holds no sheets; write some with fpnet simulate sheet')
    for path in paths:
        truth = json.loads(path.read_text(encoding='utf-8'))
        suffix = 'jpg' if truth['kind'] in ('scan', 'phone') else 'png'
        pixels = open_image(path.parent / f'sheet.{suffix}').pixels
        labels = read_labels(path.parent / 'rooms.png')[::-1]
        counts = [len(storey['rooms']) for storey in truth['storeys']]
        ends = np.cumsum([0, *counts]).tolist()
        each = [
            np.where((labels > low) & (labels <= high), labels - low, 0).astype(np.int32)
            for low, high in pairwise(ends)
        ]
        yield LabelledDrawing(path.parent.name, pixels, (*each, labels))


def labelled_plans(data: Path) -> Iterator[LabelledDrawing]:
    """Yield the real floorplans of the tune half in ``data``, as drawn and inverted."""
    for name in TUNE_FLOORS:
        pixels = open_image(data / 'bormann' / 'floorplan' / f'{name}.png').pixels
        labels = read_labels(data / 'bormann' / 'room_labels' / f'{name}.png')[::-1]
        yield LabelledDrawing(name, pixels, (labels,))
        yield LabelledDrawing(f'{name}, inverted', 255 - pixels, (labels,))


def judge_readings(
    drawing: LabelledDrawing, config: SegmentationConfig
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the figures (R, F) of all readings of a drawing, and which are right (R,)."""
    figures, is_right = [np.zeros((0, len(FEATURES)))], []
    for segmentation, H_plan_pixel in all_readings(drawing.pixels, ReadOptions(), config):
        figures.append(features(segmentation)[None])
        best = max(
            room_agreement(
                segmentation.labels, _at_cells(labels, segmentation.grid, H_plan_pixel)
            ).f1
            for labels in drawing.rooms
        )
        is_right.append(best >= GOOD_F1)
    return np.concatenate(figures), np.array(is_right, dtype=np.bool_)


def _at_cells(labels: NDArray[np.int32], grid: GridMap, H_plan_pixel: Array) -> NDArray[np.int32]:
    """Return the labels (H, W) of a picture's pixels at the cells of a grid."""
    xy = grid.rc_to_xy(np.moveaxis(np.indices(grid.shape), 0, 2))
    back = np.asarray(np.linalg.inv(H_plan_pixel), dtype=np.float64)
    places = map_points(back, xy).astype(np.float32)
    found = cv2.remap(labels.astype(np.uint16), places[..., 0], places[..., 1], cv2.INTER_NEAREST)
    return np.asarray(found, dtype=np.int32)


def gather_readings(
    drawings: Iterator[LabelledDrawing],
    config: SegmentationConfig,
    on_done: Callable[[str], None] = lambda _: None,
) -> tuple[Array, NDArray[np.bool_], NDArray[np.int64]]:
    """Return figures, truth and drawing of all readings, as :func:`fit_readings` takes them."""
    figures, is_right, sheets = [], [], []
    for number, drawing in enumerate(drawings):
        found, right = judge_readings(drawing, config)
        figures.append(found)
        is_right.append(right)
        sheets.append(np.full(len(right), number, dtype=np.int64))
        on_done(f'{drawing.name}: {int(right.sum())} of {len(right)} readings are right')
    return np.concatenate(figures), np.concatenate(is_right), np.concatenate(sheets)


def fit_readings(
    figures: Array, is_right: NDArray[np.bool_], sheets: NDArray[np.int64], seed: int
) -> tuple[dict[str, Any], Array]:
    """
    Fit the plausibility of readings.

    Parameters
    ----------
    figures : (R, F), in the order of :data:`fpnet_core.drawings.pictures.plausible.FEATURES`
    is_right : (R,), whether the rooms agree with the truth
    sheets : (R,), which sheet a reading is of; folds do not share sheets
    seed : of the solver

    Returns
    -------
    The weights as they are stored, and the probabilities (R,) of folds that were left out.
    """
    mean, std = figures.mean(axis=0), figures.std(axis=0) + 1e-9
    inputs = powers((figures - mean) / std)
    model = LogisticRegression(C=_STRENGTH, max_iter=_MAX_ITERATIONS, random_state=seed)
    held_out = cross_val_predict(
        model, inputs, is_right, groups=sheets, cv=GroupKFold(_FOLDS), method='predict_proba'
    )[:, 1]
    model.fit(inputs, is_right)
    stored = {
        'features': list(FEATURES),
        'mean': mean.round(6).tolist(),
        'std': std.round(6).tolist(),
        'weight': model.coef_[0].round(6).tolist(),
        'bias': round(float(model.intercept_[0]), 6),
        'training': {
            'readings': len(figures),
            'sheets': len(np.unique(sheets)),
            'right': int(is_right.sum()),
            'seed': seed,
        },
    }
    return stored, held_out
