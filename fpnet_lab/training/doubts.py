# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fitting what doubts readings: first which rooms are right, then which readings are wrong.

The second is fitted to what the first says of rooms that it has not learned from. All of it is
measured with buildings left out, and the probability from which on a reading is doubted is chosen
there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.ensemble import ExtraTreesRegressor
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import roc_auc_score

from fpnet_core.drawings.pictures.doubt_model import DOUBT_SCHEMA, NAMES, DoubtModel
from fpnet_core.drawings.pictures.sheet_figures import sheet_evidence
from fpnet_core.errors import FpnetError
from fpnet_core.io.weights import write_weights
from fpnet_core.small_networks import standardised
from fpnet_lab.evaluation.drawings import GOOD_F1
from fpnet_lab.training.doubt_trials import ReadingTrial

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

_LEAST_SPREAD = 1e-3  # numerical: of evidence that hardly varies
_MAX_ITERATIONS = 2000  # numerical


@dataclass(frozen=True)
class DoubtTraining:
    """Settings of a fit; the defaults were chosen by leaving buildings of the tune half out."""

    room_trees: int = 40
    room_leaf: int = 10
    """Rooms that a leaf holds at least."""
    room_leaves: int = 128
    room_figures: float = 0.5
    """Share of the figures that are tried at a node."""
    sheet_strength: float = 0.1
    """Inverse of the ridge that keeps the weights of evidence of readings small."""
    other_weight: float = 0.5
    """Of a reading that was not chosen, against a chosen one."""
    right_doubted: float = 0.05
    """Share of right readings of left-out buildings that are doubted: where the threshold is."""
    folds: int = 6
    seed: int = 0


@dataclass(frozen=True, eq=False)
class HeldOut:
    """
    What models say of buildings they have not seen.

    ``right`` holds (R,) of each trial's rooms, ``wrong (N,)`` is that of each trial.
    """

    right: list[Array]
    wrong: Array


def fit_doubts(
    trials: Sequence[ReadingTrial],
    config: DoubtTraining,
    on_fold: Callable[[float], None] = lambda _: None,
) -> tuple[DoubtModel, HeldOut]:
    """
    Fit the model to all trials, its threshold to what was held out, and return both.

    Raises
    ------
    FpnetError
        If there are fewer buildings than folds, or all readings are right or wrong.
    """
    seeds = np.array([trial.seed for trial in trials])
    wrong = np.array([trial.f1 < GOOD_F1 for trial in trials])
    if len(np.unique(seeds)) < config.folds or wrong.all() or not wrong.any():
        raise FpnetError('too few sheets to learn from: it takes right and wrong ones')
    held_out = left_out(trials, config, on_fold)
    tensors = fit_rooms(trials, config)
    tensors |= fit_sheets(*_sheets(trials, held_out.right, config), config)
    chosen = np.array([trial.is_chosen for trial in trials])
    level = threshold(held_out.wrong[chosen], wrong[chosen], config.right_doubted)
    return DoubtModel(tensors, level), held_out


def left_out(
    trials: Sequence[ReadingTrial],
    config: DoubtTraining,
    on_fold: Callable[[float], None] = lambda _: None,
) -> HeldOut:
    """Return what is said of each trial by models that have not seen its building."""
    fold = _folds(trials, config)
    right = [np.zeros(len(trial.right)) for trial in trials]
    for k in range(config.folds):
        seen = [trials[row] for row in np.flatnonzero(fold != k).tolist()]
        model = fit_rooms(seen, config)
        for row in np.flatnonzero(fold == k).tolist():
            right[row] = DoubtModel(model, 1.0).right_rooms(trials[row].rooms)
        on_fold(1.0)
    wrong = np.zeros(len(trials))
    evidence, is_wrong, weight = _sheets(trials, right, config)
    for k in range(config.folds):
        kept = fold != k
        model = fit_sheets(evidence[kept], is_wrong[kept], weight[kept], config)
        wrong[~kept] = DoubtModel(model, 1.0).wrong_sheets(evidence[~kept])
        on_fold(1.0)
    return HeldOut(right, wrong)


def _folds(trials: Sequence[ReadingTrial], config: DoubtTraining) -> NDArray[np.int64]:
    """Return the fold (N,) of each trial; a building is in one of them."""
    _, number = np.unique([trial.seed for trial in trials], return_inverse=True)
    order = np.random.default_rng(config.seed).permutation(int(number.max()) + 1)
    return np.asarray(order[number] % config.folds, dtype=np.int64)


def _sheets(
    trials: Sequence[ReadingTrial], right: Sequence[Array], config: DoubtTraining
) -> tuple[Array, Bools, Array]:
    """Return evidence, which are wrong, and weight of all readings."""
    evidence = [
        sheet_evidence(trial.whole, trial.rooms, each)
        for trial, each in zip(trials, right, strict=True)
    ]
    wrong = np.array([trial.f1 < GOOD_F1 for trial in trials])
    weight = np.where([trial.is_chosen for trial in trials], 1.0, config.other_weight)
    return np.array(evidence), wrong, weight


def fit_rooms(trials: Sequence[ReadingTrial], config: DoubtTraining) -> dict[str, NDArray[Any]]:
    """Fit the forest that tells which rooms are right; readings weigh the same."""
    forest = ExtraTreesRegressor(
        config.room_trees,
        min_samples_leaf=config.room_leaf,
        max_leaf_nodes=config.room_leaves,
        max_features=config.room_figures,
        random_state=config.seed,
    )
    weight = np.concatenate([np.full(len(t.right), 1.0 / max(len(t.right), 1)) for t in trials])
    right = np.concatenate([trial.right for trial in trials]).astype(np.float64)
    figures = np.concatenate([trial.rooms for trial in trials])
    usual = np.nan_to_num(np.nanmedian(figures, axis=0))
    forest.fit(np.where(np.isnan(figures), usual, figures), right, sample_weight=weight)
    return {f'room.{name}': value for name, value in _tensors(forest, usual).items()}


def fit_sheets(
    evidence: Array, wrong: Bools, weight: Array, config: DoubtTraining
) -> dict[str, NDArray[Any]]:
    """Fit the logistic regression over ``evidence (N, D)`` that tells which readings are wrong."""
    mean, spread = np.nanmean(evidence, axis=0), np.nanstd(evidence, axis=0) + _LEAST_SPREAD
    x = standardised(evidence, mean, spread)
    model = LogisticRegression(
        C=config.sheet_strength, max_iter=_MAX_ITERATIONS, random_state=config.seed
    )
    model.fit(x, wrong, sample_weight=weight)
    found = {'mean': mean, 'spread': spread, 'weight': model.coef_[0], 'bias': model.intercept_}
    return {f'sheet.{name}': value.astype(np.float32) for name, value in found.items()}


def _tensors(forest: ExtraTreesRegressor, usual: Array) -> dict[str, NDArray[Any]]:
    """Return a forest as :class:`fpnet_core.drawings.pictures.doubt_model.DoubtModel` takes it."""
    trees = [each.tree_ for each in forest.estimators_]
    most = max(tree.node_count for tree in trees)

    def padded(name: str, dtype: Any) -> NDArray[Any]:
        rows = [getattr(tree, name).ravel() for tree in trees]
        return np.array([np.pad(row, (0, most - len(row))) for row in rows], dtype=dtype)

    return {
        'usual': usual.astype(np.float32),
        'feature': np.maximum(padded('feature', np.int16), -1),
        'limit': padded('threshold', np.float32),
        'below': padded('children_left', np.int16),
        'above': padded('children_right', np.int16),
        'value': padded('value', np.float32),
    }


def threshold(probability: Array, wrong: Bools, right_doubted: float) -> float:
    """Return the probability (of N,) above which so large a share of the right ones lies."""
    return float(np.quantile(probability[~wrong], 1.0 - right_doubted))


def held_out_figures(
    trials: Sequence[ReadingTrial], held_out: HeldOut, doubted_from: float
) -> dict[str, float]:
    """Return how well chosen readings of left-out buildings are told right or wrong."""
    chosen = np.array([trial.is_chosen for trial in trials])
    wrong = np.array([trial.f1 < GOOD_F1 for trial in trials])[chosen]
    p = held_out.wrong[chosen]
    figures = {
        'readings': float(len(p)),
        'wrong': float(wrong.mean()),
        'auc': float(roc_auc_score(wrong, p)),
    }
    for share in (0.03, 0.05, 0.1):
        level = threshold(p, wrong, share)
        figures[f'wrong_doubted_at_{share:g}'] = float(np.mean(p[wrong] > level))
    figures['wrong_doubted'] = float(np.mean(p[wrong] > doubted_from))
    figures['right_doubted'] = float(np.mean(p[~wrong] > doubted_from))
    rooms = np.concatenate([trial.right for trial in trials])
    figures['rooms_auc'] = float(roc_auc_score(rooms, np.concatenate(held_out.right)))
    return figures


def write_doubts(
    path: Path, model: DoubtModel, config: DoubtTraining, facts: dict[str, Any]
) -> None:
    """Write the model with its manifest; ``facts`` join the manifest."""
    network: dict[str, Any] = {
        'doubted_from': model.doubted_from,
        **{key: list(figures) for key, figures in NAMES.items()},
        'room_forest': list(model.tensors['room.feature'].shape),
    }
    write_weights(
        path,
        model.tensors,
        DOUBT_SCHEMA,
        {'network': network, 'training': asdict(config), **facts},
    )
