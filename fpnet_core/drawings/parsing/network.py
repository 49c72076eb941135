# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Inference of the parser network with OpenCV.

The network returns the probability of each of the ``K`` classes of
:mod:`fpnet_core.io.pixel_classes` per pixel, and the distribution of the scale. It also has
outputs for text and furniture, which are not used yet.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.types import Chances
from fpnet_core.errors import WeightsError
from fpnet_core.io.pixel_classes import CLASSES
from fpnet_core.io.weights import read_onnx
from fpnet_core.segmentation.scale_model import ScalePrior

CONTEXT = len(CLASSES) + 1
"""Given: channels of an earlier result: class probabilities, and a mask of where it is valid."""

CHANNELS = 3 + CONTEXT
"""Given: red, green, blue and an earlier result."""

STRIDE = 64
"""Given: images are padded to multiples of this many pixels."""

SCALE_BINS, SCALE_M = 48, (0.002, 1.0)
"""Given: number of bins of metres per pixel; centres of the outer bins, spaced geometrically."""

PARSER_SCHEMA = 1
"""Given: incremented when the input of the network is prepared differently."""

PARSER_NAME = 'parser.onnx.xz'

_MIDDLE, _SPREAD = 0.75, 0.25  # numerical: normalization of brightness in [0, 1]; paper is bright


@dataclass(frozen=True, eq=False)
class Parsed:
    """``chances (K, H, W)`` of each class at each pixel, and the ``scale`` of a pixel [m]."""

    chances: Chances
    scale: ScalePrior


def parse(
    pixels: NDArray[np.uint8], context: Chances | None = None, network: Any | None = None
) -> Parsed:
    """
    Return the class probabilities and the scale of ``pixels (H, W, 3)``.

    Parameters
    ----------
    pixels : the image
    context : (CONTEXT, H, W)
        Class probabilities of an earlier pass for the same pixels; the last channel is 1 where
        they are valid. None for a first pass.
    network : from :func:`network_from`; None for the packaged one
    """
    height, width = pixels.shape[:2]
    network = network or packaged_parser()
    network.setInput(channels(pixels, context), 'picture')
    classes, scale = network.forward(['classes', 'scale'])
    logits = classes[0, : len(CLASSES), :height, :width]
    return Parsed(_softmax(np.asarray(logits, np.float32)), _pooled(scale[0]))


def _pooled(votes: Chances) -> ScalePrior:
    """Return the scale of an image from local votes and weights (SCALE_BINS + 1, h, w)."""
    bins = np.log(np.geomspace(*SCALE_M, SCALE_BINS))
    weights = _softmax(votes[-1].ravel())
    logs = votes[:-1].reshape(SCALE_BINS, -1) @ weights
    return ScalePrior(bins, logs.astype(np.float64))


def channels(pixels: NDArray[np.uint8], context: Chances | None = None) -> Chances:
    """Return the network's input (1, CHANNELS, H', W'), padded to multiples of the stride."""
    margin = ((0, -pixels.shape[0] % STRIDE), (0, -pixels.shape[1] % STRIDE))
    padded = np.pad(pixels, (*margin, (0, 0)), mode='edge').transpose(2, 0, 1)
    found = np.zeros((1, CHANNELS, *padded.shape[1:]), np.float32)
    found[0, :3] = (padded / np.float32(255.0) - _MIDDLE) / _SPREAD
    if context is not None:
        found[0, 3:, : pixels.shape[0], : pixels.shape[1]] = context
    return found


def _softmax(logits: Chances) -> Chances:
    shares = np.exp(logits - logits.max(axis=0))
    return np.asarray(shares / shares.sum(axis=0), np.float32)


@cache
def packaged_parser() -> Any:
    """Return the packaged network, read once."""
    data, manifest = read_onnx(None, PARSER_SCHEMA, PARSER_NAME)
    return network_from(data, manifest)


def network_from(data: bytes, manifest: dict[str, Any]) -> Any:
    """
    Return a network for :func:`parse` from ONNX.

    Raises
    ------
    WeightsError
        If it has other classes.
    """
    if manifest['network'].get('classes') != list(CLASSES):
        raise WeightsError(
            'parser weights: classes differ from those of this version; train again with '
            'fpnet train parser'
        )
    return cv2.dnn.readNetFromONNX(np.frombuffer(data, np.uint8))
