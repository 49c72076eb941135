# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Matching pairs as arrays: augmentation, split by plan, padded batches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
import torch
from torch import Tensor

from fpnet_core.geometry import rotation
from fpnet_core.graphs.layout import POSITION, FeatureLayout
from fpnet_core.matches import IGNORE, UNMATCHED
from fpnet_core.models.batch import GraphBatch, pad_graphs
from fpnet_core.models.inference import RegionNetwork
from fpnet_lab.sim.pairs.dataset import PairDataset
from fpnet_lab.sim.pairs.pair import MatchingPair
from fpnet_lab.training.config import AugmentationConfig
from fpnet_lab.training.networks.tensors import tensors_of, to_device

# Smallest number of regions of a crop. Chosen.
_SMALLEST_CROP = 3
# Numerical: runs of this many batches are sorted by size before batching, to reduce padding.
_SORTED_BATCHES = 8
# Given: second word of the split's seed; epoch numbers never reach it.
_SPLIT_STREAM = 2**31


@dataclass(frozen=True, eq=False)
class PairArrays:
    """
    One matching pair.

    ``plan_feat (M, D)``, ``sub_feat (N, D)`` float32; ``plan_edges (E, 2)``, ``sub_edges (E, 2)``
    int64; ``labels (N,)`` int64 plan index, UNMATCHED or IGNORE; ``plan_id`` identifies the plan
    and ``index`` the pair in its data set.
    """

    plan_feat: NDArray[np.float32]
    plan_edges: NDArray[np.int64]
    sub_feat: NDArray[np.float32]
    sub_edges: NDArray[np.int64]
    labels: NDArray[np.int64]
    plan_id: int
    index: int


@dataclass(frozen=True, eq=False)
class PairBatch:
    """Padded pairs; ``labels (B, N)`` is IGNORE in the padding."""

    plan: GraphBatch
    sub: GraphBatch
    labels: Tensor

    def to(self, device: torch.device) -> PairBatch:
        """Return the batch on ``device``."""
        plan, sub = (to_device(each, device) for each in (self.plan, self.sub))
        return PairBatch(plan, sub, self.labels.to(device))


def load_pairs(
    dataset: PairDataset, network: type[RegionNetwork], limit: int | None = None
) -> list[PairArrays]:
    """Return all stored pairs, or the first ``limit``, as rows for ``network``; 20 kB each."""
    count = len(dataset) if limit is None else min(limit, len(dataset))
    return [pair_arrays(dataset.pair(index), network, index) for index in range(count)]


def pair_arrays(pair: MatchingPair, network: type[RegionNetwork], index: int) -> PairArrays:
    """Return pair ``index`` of a data set as node rows for ``network``."""
    return PairArrays(
        plan_feat=network.rows(pair.plan_graph),
        plan_edges=pair.plan_graph.edges,
        sub_feat=network.rows(pair.sub_graph),
        sub_edges=pair.sub_graph.edges,
        labels=pair.sub_labels,
        plan_id=pair.plan_id,
        index=index,
    )


def split_by_plan(
    pairs: Sequence[PairArrays], fraction: float, seed: int
) -> tuple[list[PairArrays], list[PairArrays]]:
    """
    Return training and validation pairs with disjoint plans.

    About ``fraction`` of the plans, and at least one, is held back. Each plan is assigned
    independently, so held-back plans stay held back if a run continues with more data.
    """
    draws = {
        plan: np.random.default_rng([seed, _SPLIT_STREAM, plan]).random()
        for plan in {pair.plan_id for pair in pairs}
    }
    limit = max(fraction, min(draws.values()))
    return (
        [pair for pair in pairs if draws[pair.plan_id] > limit],
        [pair for pair in pairs if draws[pair.plan_id] <= limit],
    )


def split_by_pair(
    pairs: Sequence[PairArrays], fraction: float, seed: int
) -> tuple[list[PairArrays], list[PairArrays]]:
    """Return training and validation pairs of one building, where no split by plan exists."""
    held = np.random.default_rng([seed, _SPLIT_STREAM]).random(len(pairs)) <= fraction
    held[0] = True
    return (
        [pair for pair, is_held in zip(pairs, held, strict=True) if not is_held],
        [pair for pair, is_held in zip(pairs, held, strict=True) if is_held],
    )


def collate(pairs: Sequence[PairArrays]) -> PairBatch:
    """Return pairs padded into one batch."""
    plan = tensors_of(pad_graphs([p.plan_feat for p in pairs], [p.plan_edges for p in pairs]))
    sub = tensors_of(pad_graphs([p.sub_feat for p in pairs], [p.sub_edges for p in pairs]))
    labels = np.full(sub.mask.shape, IGNORE, dtype=np.int64)
    for row, pair in zip(labels, pairs, strict=True):
        row[: len(pair.labels)] = pair.labels
    return PairBatch(plan, sub, torch.from_numpy(labels))


def batch_order(
    sizes: NDArray[np.int64], batch_size: int, rng: np.random.Generator
) -> list[NDArray[np.int64]]:
    """Return shuffled index batches of pairs with similar ``sizes``; each pair occurs once."""
    order = rng.permutation(len(sizes))
    batches: list[NDArray[np.int64]] = []
    run = batch_size * _SORTED_BATCHES
    for start in range(0, len(order), run):
        chunk = order[start : start + run]
        chunk = chunk[np.argsort(sizes[chunk], kind='stable')]
        batches += [chunk[i : i + batch_size] for i in range(0, len(chunk), batch_size)]
    return [batches[i] for i in rng.permutation(len(batches))]


@dataclass(frozen=True)
class Share:
    """Index and number of processes; batches are distributed in turn and equally."""

    index: int = 0
    count: int = 1

    def of(self, batches: int) -> int:
        """Return the number of batches per process."""
        return batches // self.count


def training_batches(
    pairs: Sequence[PairArrays],
    layout: FeatureLayout,
    batch_size: int,
    config: AugmentationConfig,
    stream: Sequence[int],
    share: Share = Share(),
) -> Iterator[PairBatch]:
    """Yield this process's share of one epoch of augmented batches; ``stream`` is the seed."""
    rng = np.random.default_rng(stream)
    sizes = np.array([len(pair.plan_feat) for pair in pairs])
    order = batch_order(sizes, batch_size, rng)
    if share.count > 1:
        rng = np.random.default_rng([*stream, share.index])
    for batch in order[share.index :: share.count][: share.of(len(order))]:
        yield collate([augment(pairs[index], layout, config, rng) for index in batch])


def augment(
    pair: PairArrays,
    layout: FeatureLayout,
    config: AugmentationConfig,
    rng: np.random.Generator,
) -> PairArrays:
    """Return the pair rotated, cropped, mirrored, with noise and without some regions."""
    crops = rng.random(2) < config.crop_probability
    keep_plan = _crop(pair.plan_edges, len(pair.plan_feat), crops[0], rng)
    pair = _without(pair, keep_plan, _crop(pair.sub_edges, len(pair.sub_feat), crops[1], rng))
    pair = _drop_regions(pair, config.drop_probability, rng)
    mirror = rng.random() < config.mirror_probability
    log_scale = config.scale_noise * rng.standard_normal()
    noise = config.feature_noise
    return replace(
        pair,
        plan_feat=_perturb(pair.plan_feat, layout, mirror, 0.0, noise, rng),
        sub_feat=_perturb(pair.sub_feat, layout, mirror, log_scale, noise, rng),
    )


def _perturb(
    rows: NDArray[np.float32],
    layout: FeatureLayout,
    mirror: bool,
    log_scale: float,
    noise: float,
    rng: np.random.Generator,
) -> NDArray[np.float32]:
    rows = rows.copy()
    if mirror:
        rows[:, layout.odd] *= -1.0
    yaw = rng.uniform(-np.pi, np.pi)
    rows[:, POSITION] = np.exp(log_scale) * rows[:, POSITION] @ rotation(yaw).T
    if layout.axis is not None:
        rows[:, layout.axis] = rows[:, layout.axis] @ rotation(2.0 * yaw).T
    rows[:, layout.noisy] += noise * rng.standard_normal(rows[:, layout.noisy].shape)
    rows[:, layout.log_lengths] += log_scale
    return rows


def _crop(
    edges: NDArray[np.int64], count: int, is_wanted: bool, rng: np.random.Generator
) -> NDArray[np.bool_]:
    """Return a mask of a connected part of random size, like a partly explored or drawn map."""
    if not (is_wanted and count):
        return np.ones(count, dtype=np.bool_)
    wanted = int(rng.integers(min(_SMALLEST_CROP, count), count + 1))
    neighbours: list[list[int]] = [[] for _ in range(count)]
    for a, b in edges.tolist():
        neighbours[a].append(b)
        neighbours[b].append(a)
    keep = np.zeros(count, dtype=np.bool_)
    border = [int(rng.integers(count))]
    keep[border] = True
    while border and keep.sum() < wanted:
        node = border.pop(int(rng.integers(len(border))))
        fresh = [other for other in neighbours[node] if not keep[other]]
        keep[fresh] = True
        border += fresh
    return keep


def _drop_regions(pair: PairArrays, probability: float, rng: np.random.Generator) -> PairArrays:
    """Return the pair without random regions of both graphs."""
    keep_plan = _kept(len(pair.plan_feat), probability, rng)
    return _without(pair, keep_plan, _kept(len(pair.sub_feat), probability, rng))


def _without(
    pair: PairArrays, keep_plan: NDArray[np.bool_], keep_sub: NDArray[np.bool_]
) -> PairArrays:
    """Return the pair with some regions kept; partners of removed plan regions are UNMATCHED."""
    labels = pair.labels[keep_sub]
    renumbered = _renumber(keep_plan)
    matched = labels >= 0
    return replace(
        pair,
        plan_feat=pair.plan_feat[keep_plan],
        plan_edges=_kept_edges(pair.plan_edges, keep_plan),
        sub_feat=pair.sub_feat[keep_sub],
        sub_edges=_kept_edges(pair.sub_edges, keep_sub),
        labels=np.where(matched, renumbered[np.where(matched, labels, 0)], labels),
    )


def _kept(count: int, probability: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return a random mask of nodes to keep, at least one."""
    keep = rng.random(count) >= probability
    return keep if keep.any() else np.ones(count, dtype=np.bool_)


def _renumber(keep: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return new indices of kept nodes, UNMATCHED for dropped ones."""
    return np.where(keep, np.cumsum(keep) - 1, UNMATCHED)


def _kept_edges(edges: NDArray[np.int64], keep: NDArray[np.bool_]) -> NDArray[np.int64]:
    renumbered = _renumber(keep)[edges]
    return renumbered[(renumbered >= 0).all(axis=1)]
