# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A stream of views to train the parser on, drawn by several processes while it learns."""

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

_POOL = 24  # numerical: drawings that a process cuts views from
_PER_SAMPLE = 6  # numerical: views that are cut for each new drawing
_BIN_SPREAD = 0.7  # of bins, by which a true scale is blurred; chosen


@dataclass(frozen=True)
class Chunk:
    """
    A few pairs of views: ``N`` pairs of first and second looks of ``S`` by ``S`` pixels.

    ``pixels (N, 2, 3, S, S)`` uint8, ``answers (N, 2, S, S)`` uint8, ``theta (N, 2, 3)`` from a
    second look's place to the first look's as ``affine_grid`` has it, ``scale (N, 2, SCALE_BINS)``
    the true scale's probabilities, zero where there is none.
    """

    pixels: Tensor
    answers: Tensor
    theta: Tensor
    scale: Tensor


class ViewStream(IterableDataset[Chunk]):
    """Chunks without end; equal seeds, workers and starts give equal chunks."""

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
    """Return a map of pixels (2, 3) as one of coordinates from -1 to 1 between outer edges."""
    N = np.array(
        [
            [2.0 / side_px, 0.0, 1.0 / side_px - 1.0],
            [0.0, 2.0 / side_px, 1.0 / side_px - 1.0],
            [0, 0, 1],
        ]
    )
    return np.asarray((N @ np.vstack([A, [0.0, 0.0, 1.0]]) @ np.linalg.inv(N))[:2])


def scale_target(pixel_m: float) -> np.ndarray[tuple[int], np.dtype[np.float32]]:
    """Return the probabilities (SCALE_BINS,) of a true scale, blurred; zeros where it is NaN."""
    if not np.isfinite(pixel_m):
        return np.zeros(SCALE_BINS, np.float32)
    low, high = np.log(SCALE_M)
    place = (np.log(pixel_m) - low) / (high - low) * (SCALE_BINS - 1)
    shares = np.exp(-0.5 * ((np.arange(SCALE_BINS) - place) / _BIN_SPREAD) ** 2)
    return np.asarray(shares / max(shares.sum(), 1e-9), np.float32)
