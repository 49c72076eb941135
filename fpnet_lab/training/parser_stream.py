# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Stream of training views for the parser, generated in parallel during training."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import cv2
import numpy as np
import torch
from torch import Tensor
from torch.utils.data import IterableDataset, get_worker_info

from fpnet_core.drawings.parsing.network import SCALE_BINS, SCALE_M
from fpnet_lab.training.parser_samples import FIRST_SEED, Sample, real_samples, samples
from fpnet_lab.training.parser_views import Array, SampleView, two_views

_POOL = 24  # numerical: drawings per process from which views are taken
_PER_SAMPLE = 6  # numerical: views per new drawing
_BIN_SPREAD = 0.7  # standard deviation in bins of the blurred true scale; chosen


@dataclass(frozen=True)
class Chunk:
    """
    ``N`` pairs of first and second views of ``S`` by ``S`` pixels.

    ``pixels (N, 2, 3, S, S)`` uint8, ``answers (N, 2, S, S)`` uint8, ``theta (N, 2, 3)`` from the
    second view to the first in the convention of ``affine_grid``, ``scale (N, 2, SCALE_BINS)`` the
    true scale's probabilities, zero if unknown.
    """

    pixels: Tensor
    answers: Tensor
    theta: Tensor
    scale: Tensor


class ViewStream(IterableDataset[Chunk]):
    """Infinite stream of chunks; equal seeds, workers and starts give equal chunks."""

    def __init__(self, side_px: int, chunk: int, seed: int, start: int, data: Path | None) -> None:
        self.side_px, self.chunk, self.data = side_px, chunk, data
        self.seed, self.start = seed, start

    def __iter__(self) -> Iterator[Chunk]:
        cv2.setNumThreads(1)
        info = get_worker_info()
        worker, workers = (0, 1) if info is None else (info.id, info.num_workers)
        rng = np.random.default_rng([self.seed, self.start, worker])
        first = FIRST_SEED + self.start + worker
        real = real_samples(self.data) if self.data is not None else []
        source = samples(rng, first, workers, real)
        pool: list[Sample] = []
        for number in count():
            if number % _PER_SAMPLE == 0 or len(pool) < 2:
                pool = [*pool[-(_POOL - 1) :], next(source)]
            if number % self.chunk == 0:
                pairs: list[tuple[SampleView, SampleView, Array]] = []
            pairs.append(two_views(pool[int(rng.integers(len(pool)))], self.side_px, rng))
            if len(pairs) == self.chunk:
                yield _chunk(pairs, self.side_px)


def _chunk(pairs: list[tuple[SampleView, SampleView, Array]], side_px: int) -> Chunk:
    views = [(first, second) for first, second, _ in pairs]
    pixels = np.stack([[v.pixels.transpose(2, 0, 1) for v in two] for two in views])
    answers = np.stack([[v.answers for v in two] for two in views])
    scale = np.stack([[scale_target(v.pixel_m) for v in two] for two in views])
    theta = np.stack([_theta(A, side_px) for _, _, A in pairs]).astype(np.float32)
    return Chunk(*(torch.from_numpy(each) for each in (pixels, answers, theta, scale)))


def _theta(A: Array, side_px: int) -> Array:
    """Return a pixel map (2, 3) in coordinates from -1 to 1 between outer edges."""
    N = np.array(
        [
            [2.0 / side_px, 0.0, 1.0 / side_px - 1.0],
            [0.0, 2.0 / side_px, 1.0 / side_px - 1.0],
            [0, 0, 1],
        ]
    )
    return np.asarray((N @ np.vstack([A, [0.0, 0.0, 1.0]]) @ np.linalg.inv(N))[:2])


def scale_target(pixel_m: float) -> np.ndarray[tuple[int], np.dtype[np.float32]]:
    """Return the blurred probabilities (SCALE_BINS,) of a true scale; zeros for NaN."""
    if not np.isfinite(pixel_m):
        return np.zeros(SCALE_BINS, np.float32)
    low, high = np.log(SCALE_M)
    place = (np.log(pixel_m) - low) / (high - low) * (SCALE_BINS - 1)
    shares = np.exp(-0.5 * ((np.arange(SCALE_BINS) - place) / _BIN_SPREAD) ** 2)
    return np.asarray(shares / max(shares.sum(), 1e-9), np.float32)
