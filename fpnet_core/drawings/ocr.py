# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""OCR of texts in images with RapidOCR (optional extra ``ocr``)."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib.util import find_spec
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.types import Drawing, Label, Reading, ReadOptions, ScaleSource
from fpnet_core.errors import ConfigError

NOT_READ = "texts on the picture were not read: pip install 'fpnet_ros[ocr]'"
"""Note for an image whose texts could have stated its scale."""

_MODELS = {'Det': '*det*.onnx', 'Cls': '*cls*.onnx', 'Rec': '*rec*.onnx'}  # given: in the wheel
_MOST_PX = 3.2e6  # numerical: largest image for text detection [pixels], 3 s on one core
_MOST_TEXTS = 250  # numerical: largest number of texts, 0.05 s each on one core
_ENLARGED_PX = 2.0e6  # numerical: smaller images are enlarged to this size [pixels]
_LARGEST_FACTOR = 2.0  # numerical: largest enlargement of small images
_LEAST_SCORE = 0.75  # smallest score of an accepted text; chosen


def is_installed() -> bool:
    """Return whether the OCR packages are installed."""
    return find_spec('rapidocr') is not None and find_spec('onnxruntime') is not None


def with_texts(drawing: Drawing, options: ReadOptions) -> Drawing:
    """
    Return an image of unknown scale with its texts as labels.

    Vector drawings, images of known scale and, without the extra ``ocr``, all drawings are
    returned unchanged.
    """
    is_stated = options.resolution_m is not None or options.length is not None
    if is_stated or drawing.scale is not None or not _is_picture(drawing) or not is_installed():
        return drawing
    return replace(drawing, labels=read_labels(drawing.pixels))


def is_unread(reading: Reading) -> bool:
    """Return whether an image's scale is an estimate and OCR, which might state it, is missing."""
    is_known = reading.scale.source is not ScaleSource.ESTIMATED
    return not is_known and _is_picture(reading.drawing) and not is_installed()


def _is_picture(drawing: Drawing) -> bool:
    has_lines = drawing.strokes is not None and len(drawing.strokes.ends) > 0
    return not has_lines and not drawing.labels


def read_labels(pixels: NDArray[np.uint8]) -> tuple[Label, ...]:
    """
    Return the texts in ``pixels (H, W, 3)``, uint8 RGB; an empty tuple if there are none.

    A sheet of 3,500 pixels takes about 10 s on one core. Nothing is downloaded.

    Raises
    ------
    ConfigError
        If the extra ``ocr`` is not installed.
    """
    if not is_installed():
        raise ConfigError(NOT_READ)
    import cv2

    height, width = pixels.shape[:2]
    factor = math.sqrt(_MOST_PX / (height * width))
    if factor > 1.0:
        factor = min(_LARGEST_FACTOR, max(1.0, math.sqrt(_ENLARGED_PX / (height * width))))
    size = (max(1, round(width * factor)), max(1, round(height * factor)))
    way = cv2.INTER_AREA if factor < 1.0 else cv2.INTER_CUBIC
    shown = cv2.resize(pixels, size, interpolation=way) if factor != 1.0 else pixels
    found = _engine()(np.ascontiguousarray(shown[..., ::-1]))
    if found.txts is None:
        return ()
    back = np.array([width, height]) / size
    labels = []
    for text, score, corners in zip(found.txts, found.scores, found.boxes, strict=True):
        placed = (np.asarray(corners, np.float64).reshape(4, 2) + 0.5) * back - 0.5
        if score >= _LEAST_SCORE and text.strip():
            (left, top), (right, bottom) = placed.min(axis=0).tolist(), placed.max(axis=0).tolist()
            labels.append(Label(text.strip(), (left, top, right, bottom)))
    return tuple(labels)


@cache
def _engine() -> Any:
    """Return the OCR engine with the models of its package, on one core."""
    import rapidocr

    folder = Path(rapidocr.__file__).parent / 'models'
    params: dict[str, Any] = {
        'Global.log_level': 'error',
        'Global.max_side_len': 1 << 15,  # read_labels limits the number of pixels
        'Det.limit_side_len': 32,  # no further enlargement
        'Det.max_candidates': _MOST_TEXTS,
        'EngineConfig.onnxruntime.intra_op_num_threads': 1,
        'EngineConfig.onnxruntime.inter_op_num_threads': 1,
    }
    for part, pattern in _MODELS.items():
        models = sorted(folder.glob(pattern))
        if not models:
            raise ConfigError(
                f'no model {pattern} in {folder}: expected those of rapidocr 3.10; install it '
                "again with pip install 'fpnet_ros[ocr]'"
            )
        params[f'{part}.model_path'] = str(models[0])
    return rapidocr.RapidOCR(params=params)
