# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fit of the parse quality model: right rooms, wrong parses, and images that are no floorplans.

The second and third parts are fitted to the first part's predictions for rooms that were left out.
All figures and thresholds come from left-out buildings: above one threshold a parse gets a
warning, above the other an image is no floorplan.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import roc_auc_score

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.doubts import (
    ROOM_FIGURES,
    SHEET_FIGURES,
    DoubtModel,
    Regression,
    SheetEvidence,
    best_overlap,
    evidence_of,
    sheet_figures,
)
from fpnet_core.errors import FpnetError
from fpnet_core.small_networks import standardised
from fpnet_lab.evaluation.drawings import GOOD_F1, compared
from fpnet_lab.kept import make_once
from fpnet_lab.sim.sheets import SheetKind, draw_sheet
from fpnet_lab.sim.sheets.negatives import draw_negative
from fpnet_lab.training.sheets_read import COMPARED_CELLS, picture_read, read_from_file

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

FIRST_SEED = 4000
"""
Numerical: first seed of training sheets: seeds of the development split unused by the benchmark.
"""

OTHER = 'other'
"""Kind of images without a building. Given."""

_OTHERS = 8  # numerical: number of such images per building
_SAME_IOU = 0.5  # given: of a found and a true room, as in the benchmark
_LEAST_SPREAD = 1e-3  # numerical: of an almost constant feature
_MAX_ITERATIONS = 2000  # numerical


@dataclass(frozen=True, eq=False)
class DoubtTrial:
    """
    Parsed sheet: evidence ``rooms (R, D)`` and ``whole (F,)``, and the truth.

    ``right (R,)`` marks right rooms; ``f1`` is the room F1. Sheets of one ``seed`` show the same
    building; those of kind :data:`OTHER` show none.
    """

    kind: str
    seed: int
    f1: float
    rooms: Array
    right: Bools
    whole: Array

    @property
    def evidence(self) -> SheetEvidence:
        """Evidence for the quality model."""
        return SheetEvidence(self.rooms, self.whole)

    @property
    def is_wrong(self) -> bool:
        """Return whether the rooms are wrong."""
        return self.f1 < GOOD_F1


@dataclass(frozen=True)
class DoubtTraining:
    """Settings of a fit; the defaults were chosen by cross-validation on the development split."""

    room_strength: float = 1.0
    sheet_strength: float = 0.1
    """Inverse ridge penalties on the weights of features."""
    right_doubted: float = 0.05
    """Share of left-out right parses that get a warning: determines the threshold."""
    taken_for_other: float = 0.0
    """Share of left-out buildings, right or wrong, classified as no floorplan."""
    folds: int = 6
    seed: int = 0


@dataclass(frozen=True, eq=False)
class HeldOut:
    """
    Predictions of models for left-out buildings.

    ``right`` holds probabilities (R,) for each building's rooms, ``wrong (N,)`` those for each
    building, and ``other (N,)`` those for each trial, images without a building last.
    """

    right: list[Array]
    wrong: Array
    other: Array


def gather_trials(
    folder: Path,
    seeds: Sequence[int],
    config: SegmentationConfig,
    workers: int = 1,
    on_sheet: Callable[[float], None] = lambda _: None,
) -> list[DoubtTrial]:
    """Return the trials of all sheets and other images; results in ``folder`` are reused."""
    tasks: dict[str, tuple[int, SheetKind | None]] = {
        f'{kind.value}-{seed}': (seed, kind) for seed, kind in product(seeds, SheetKind)
    }
    others = [_OTHERS * seed + k for seed, k in product(seeds, range(_OTHERS))]
    tasks |= {f'{OTHER}-{seed}': (seed, None) for seed in others}
    made = make_once(
        folder,
        tuple[DoubtTrial, ...],
        tasks,
        partial(sheet_trials, config),
        workers,
        on_sheet,
        (*ROOM_FIGURES, *SHEET_FIGURES),
    )
    return [trial for trials in made for trial in trials]


def sheet_trials(
    config: SegmentationConfig, drawn: tuple[int, SheetKind | None]
) -> tuple[DoubtTrial, ...]:
    """Parse a sheet from a file; return no trial if it is rejected or has no rooms."""
    seed, of_kind = drawn
    if of_kind is None:
        return _other_trials(seed, config)
    sheet = draw_sheet(seed, of_kind)
    read = read_from_file(sheet, config)
    if read is None or read.found.seen is None or not read.found.segmentation.rooms:
        return ()
    evidence = evidence_of(read.found, config)
    H_plan_page = read.found.H_plan_pixel @ read.H_pixel_page
    truth = compared(sheet, read.found.segmentation, H_plan_page, COMPARED_CELLS)
    right = best_overlap(truth.found, truth.true, len(evidence.rooms)) > _SAME_IOU
    kind = sheet.kind.value
    return (DoubtTrial(kind, sheet.seed, truth.f1, evidence.rooms, right, evidence.whole),)


def _other_trials(seed: int, config: SegmentationConfig) -> tuple[DoubtTrial, ...]:
    found = picture_read(draw_negative(seed), config)
    if found is None or found.seen is None or not found.segmentation.rooms:
        return ()
    evidence = evidence_of(found, config)
    right = np.zeros(len(evidence.rooms), np.bool_)
    return (DoubtTrial(OTHER, seed, 0.0, evidence.rooms, right, evidence.whole),)


def fit_doubts(
    trials: Sequence[DoubtTrial],
    config: DoubtTraining,
    on_fold: Callable[[float], None] = lambda _: None,
) -> tuple[DoubtModel, HeldOut]:
    """
    Fit the model to all trials and its thresholds to the held-out predictions; return both.

    Raises
    ------
    FpnetError
        If there are fewer buildings than folds, all of them are right or wrong, or all images show
        a building.
    """
    buildings, others = _parted(trials)
    wrong = _wrong(buildings)
    seeds = {trial.seed for trial in buildings}
    if len(seeds) < config.folds or wrong.all() or not wrong.any() or not others:
        raise FpnetError(
            'too few sheets to learn from; provide right and wrong ones, and other images'
        )
    held_out = left_out(trials, config, on_fold)
    doubted_from = threshold(held_out.wrong, wrong, config.right_doubted)
    is_other = np.arange(len(trials)) >= len(buildings)
    other_from = threshold(held_out.other, is_other, config.taken_for_other)
    rooms = fit_rooms(buildings, config)
    wrong_sheet = fit_sheets(buildings, held_out.right, config)
    figures = _figures([*buildings, *others], _all_right(held_out.right, others, rooms))
    other = _fitted(figures, is_other, None, config.sheet_strength)
    return DoubtModel(rooms, wrong_sheet, other, doubted_from, other_from), held_out


def _parted(trials: Sequence[DoubtTrial]) -> tuple[list[DoubtTrial], list[DoubtTrial]]:
    """Return the trials of buildings, and those of other images."""
    buildings = [trial for trial in trials if trial.kind != OTHER]
    return buildings, [trial for trial in trials if trial.kind == OTHER]


def _all_right(
    right: Sequence[Array], others: Sequence[DoubtTrial], rooms: Regression
) -> list[Array]:
    """Return predictions (R,) for each trial's rooms; those of buildings are held out."""
    return [*right, *(rooms(trial.rooms) for trial in others)]


def left_out(
    trials: Sequence[DoubtTrial],
    config: DoubtTraining,
    on_fold: Callable[[float], None] = lambda _: None,
) -> HeldOut:
    """Return predictions for each trial by models that were fitted without its building."""
    trials, others = _parted(trials)
    fold = _folds(trials, config)
    right = [np.zeros(len(trial.right)) for trial in trials]
    for k in range(config.folds):
        rooms = fit_rooms([trials[row] for row in np.flatnonzero(fold != k).tolist()], config)
        for row in np.flatnonzero(fold == k).tolist():
            right[row] = rooms(trials[row].rooms)
        on_fold(1.0)
    wrong = np.zeros(len(trials))
    for k in range(config.folds):
        seen, unseen = (np.flatnonzero(mask).tolist() for mask in (fold != k, fold == k))
        sheets = fit_sheets([trials[row] for row in seen], [right[row] for row in seen], config)
        wrong[unseen] = sheets(_figures(trials, right)[unseen])
        on_fold(1.0)
    every = [*trials, *others]
    figures = _figures(every, _all_right(right, others, fit_rooms(trials, config)))
    return HeldOut(right, wrong, _left_out_others(every, figures, config))


def _left_out_others(trials: Sequence[DoubtTrial], figures: Array, config: DoubtTraining) -> Array:
    """Return the probability (N,) that each trial shows no building, by leaving out its seed."""
    fold = _folds(trials, config)
    is_other = np.array([trial.kind == OTHER for trial in trials])
    other = np.zeros(len(trials))
    for k in range(config.folds):
        unseen = fold == k
        model = _fitted(figures[~unseen], is_other[~unseen], None, config.sheet_strength)
        other[unseen] = model(figures[unseen])
    return other


def _folds(trials: Sequence[DoubtTrial], config: DoubtTraining) -> NDArray[np.int64]:
    """Return the fold (N,) of each trial; all trials of a building are in one fold."""
    _, number = np.unique([trial.seed for trial in trials], return_inverse=True)
    order = np.random.default_rng(config.seed).permutation(int(number.max()) + 1)
    return np.asarray(order[number] % config.folds, dtype=np.int64)


def _wrong(trials: Sequence[DoubtTrial]) -> Bools:
    return np.array([trial.is_wrong for trial in trials], np.bool_)


def _figures(trials: Sequence[DoubtTrial], right: Sequence[Array]) -> Array:
    pairs = zip(trials, right, strict=True)
    return np.array([sheet_figures(trial.evidence, each) for trial, each in pairs])


def fit_rooms(trials: Sequence[DoubtTrial], config: DoubtTraining) -> Regression:
    """Fit the model of right rooms; buildings have equal weight."""
    weight = np.concatenate([np.full(len(t.right), 1.0 / len(t.right)) for t in trials])
    right = np.concatenate([trial.right for trial in trials])
    figures = np.concatenate([trial.rooms for trial in trials])
    return _fitted(figures, right, len(right) * weight / weight.sum(), config.room_strength)


def fit_sheets(
    trials: Sequence[DoubtTrial], right: Sequence[Array], config: DoubtTraining
) -> Regression:
    """Fit the model of wrong parses; ``right (R,)`` are the room probabilities of each trial."""
    return _fitted(_figures(trials, right), _wrong(trials), None, config.sheet_strength)


def _fitted(figures: Array, is_so: Bools, weight: Array | None, strength: float) -> Regression:
    mean, spread = figures.mean(axis=0), figures.std(axis=0) + _LEAST_SPREAD
    model = LogisticRegression(C=strength, max_iter=_MAX_ITERATIONS)
    model.fit(standardised(figures, mean, spread), is_so, sample_weight=weight)
    return Regression(mean, spread, model.coef_[0], float(model.intercept_[0]))


def threshold(probability: Array, wrong: Bools, right_doubted: float) -> float:
    """Return the threshold on ``probability (N,)`` exceeded by a share of the right ones."""
    return float(np.quantile(probability[~wrong], 1.0 - right_doubted))


def held_out_figures(
    trials: Sequence[DoubtTrial], held_out: HeldOut, model: DoubtModel
) -> dict[str, float]:
    """Return the classification figures for left-out buildings and other images."""
    trials, others = _parted(trials)
    wrong, p = _wrong(trials), held_out.wrong
    figures = {
        'readings': float(len(p)),
        'wrong': float(wrong.mean()),
        'auc': float(roc_auc_score(wrong, p)),
    }
    for share in (0.03, 0.05, 0.1):
        level = threshold(p, wrong, share)
        figures[f'wrong_doubted_at_{share:g}'] = float(np.mean(p[wrong] > level))
    figures['wrong_doubted'] = float(np.mean(p[wrong] > model.doubted_from))
    figures['right_doubted'] = float(np.mean(p[~wrong] > model.doubted_from))
    rooms = np.concatenate([trial.right for trial in trials])
    taken = held_out.other > model.other_from
    figures['others'] = float(len(others))
    figures['others_known'] = float(np.mean(taken[len(trials) :]))
    figures['buildings_taken_for_others'] = float(np.mean(taken[: len(trials)]))
    figures['rooms_auc'] = float(roc_auc_score(rooms, np.concatenate(held_out.right)))
    return figures


def write_doubts(
    path: Path, model: DoubtModel, config: DoubtTraining, facts: dict[str, Any]
) -> None:
    """Write the model; ``facts`` join its manifest."""
    stored = {
        'doubted_from': round(model.doubted_from, 6),
        'other_from': round(model.other_from, 6),
        'rooms': _stored(model.right_room, ROOM_FIGURES),
        'sheets': _stored(model.wrong_sheet, SHEET_FIGURES),
        'others': _stored(model.other_picture, SHEET_FIGURES),
        'training': asdict(config),
        **facts,
    }
    path.write_text(json.dumps(stored, indent=1) + '\n', encoding='utf-8')


def _stored(model: Regression, names: Sequence[str]) -> dict[str, Any]:
    return {
        'figures': list(names),
        'mean': model.mean.round(6).tolist(),
        'spread': model.spread.round(6).tolist(),
        'weight': model.weight.round(6).tolist(),
        'bias': round(model.bias, 6),
    }
