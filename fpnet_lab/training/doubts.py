# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fitting what doubts a building: which rooms are right, which buildings are, which are none at all.

The second and third are fitted to what the first says of rooms that it has not learned from. All
of it is measured with buildings left out, and the probabilities from which on a building is
doubted, and a picture is no floorplan, are chosen there.
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
Numerical: of the sheets to learn from: seeds of the tune half that the benchmark does not reach.
"""

OTHER = 'other'
"""The kind of pictures that show no building. Given."""

_OTHERS = 8  # numerical: such pictures for each building
_SAME_IOU = 0.5  # given: of a room found and a true one, as the benchmark has it
_LEAST_SPREAD = 1e-3  # numerical: of evidence that hardly varies
_MAX_ITERATIONS = 2000  # numerical


@dataclass(frozen=True, eq=False)
class DoubtTrial:
    """
    A sheet that was read: evidence ``rooms (R, D)`` and ``whole (F,)``, and the truth.

    Its rooms are ``right (R,)``; ``f1`` is that of its rooms. Sheets of one ``seed`` share a
    building; of the kind :data:`OTHER` there is none.
    """

    kind: str
    seed: int
    f1: float
    rooms: Array
    right: Bools
    whole: Array

    @property
    def evidence(self) -> SheetEvidence:
        """What there is to see of it."""
        return SheetEvidence(self.rooms, self.whole)

    @property
    def is_wrong(self) -> bool:
        """Tell whether its rooms are not those of the truth."""
        return self.f1 < GOOD_F1


@dataclass(frozen=True)
class DoubtTraining:
    """Settings of a fit; the defaults were chosen by leaving buildings of the tune half out."""

    room_strength: float = 1.0
    sheet_strength: float = 0.1
    """Inverse of the ridges that keep the weights of figures small."""
    right_doubted: float = 0.05
    """Share of right buildings, left out, that are doubted: where the threshold is."""
    taken_for_other: float = 0.0
    """Share of buildings, right or wrong, left out, that are taken for something else."""
    folds: int = 6
    seed: int = 0


@dataclass(frozen=True, eq=False)
class HeldOut:
    """
    What models say of buildings they have not seen.

    ``right`` holds (R,) of each building's rooms, ``wrong (N,)`` is that of each building, and
    ``other (N,)`` of each trial, those of no building last.
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
    """Return the trials of all sheets and other pictures; what ``folder`` holds is taken over."""
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
    """Read a sheet from a file as a user's; none where it is refused or has no rooms."""
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
    Fit the model to all trials, its thresholds to what was held out, and return both.

    Raises
    ------
    FpnetError
        If there are fewer buildings than folds, all of them are right or wrong, or no picture
        shows none.
    """
    buildings, others = _parted(trials)
    wrong = _wrong(buildings)
    seeds = {trial.seed for trial in buildings}
    if len(seeds) < config.folds or wrong.all() or not wrong.any() or not others:
        raise FpnetError(
            'too few sheets to learn from: it takes right and wrong ones, and other pictures'
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
    """Return the trials of buildings, and those of other pictures."""
    buildings = [trial for trial in trials if trial.kind != OTHER]
    return buildings, [trial for trial in trials if trial.kind == OTHER]


def _all_right(
    right: Sequence[Array], others: Sequence[DoubtTrial], rooms: Regression
) -> list[Array]:
    """Return how right (R,) each trial's rooms seem, of buildings as they were left out."""
    return [*right, *(rooms(trial.rooms) for trial in others)]


def left_out(
    trials: Sequence[DoubtTrial],
    config: DoubtTraining,
    on_fold: Callable[[float], None] = lambda _: None,
) -> HeldOut:
    """Return what is said of each trial by models that have not seen its building."""
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
    """Return how probably (N,) each trial is another picture, by those of other seeds."""
    fold = _folds(trials, config)
    is_other = np.array([trial.kind == OTHER for trial in trials])
    other = np.zeros(len(trials))
    for k in range(config.folds):
        unseen = fold == k
        model = _fitted(figures[~unseen], is_other[~unseen], None, config.sheet_strength)
        other[unseen] = model(figures[unseen])
    return other


def _folds(trials: Sequence[DoubtTrial], config: DoubtTraining) -> NDArray[np.int64]:
    """Return the fold (N,) of each trial; a building is in one of them."""
    _, number = np.unique([trial.seed for trial in trials], return_inverse=True)
    order = np.random.default_rng(config.seed).permutation(int(number.max()) + 1)
    return np.asarray(order[number] % config.folds, dtype=np.int64)


def _wrong(trials: Sequence[DoubtTrial]) -> Bools:
    return np.array([trial.is_wrong for trial in trials], np.bool_)


def _figures(trials: Sequence[DoubtTrial], right: Sequence[Array]) -> Array:
    pairs = zip(trials, right, strict=True)
    return np.array([sheet_figures(trial.evidence, each) for trial, each in pairs])


def fit_rooms(trials: Sequence[DoubtTrial], config: DoubtTraining) -> Regression:
    """Fit what tells which rooms are right; buildings weigh the same."""
    weight = np.concatenate([np.full(len(t.right), 1.0 / len(t.right)) for t in trials])
    right = np.concatenate([trial.right for trial in trials])
    figures = np.concatenate([trial.rooms for trial in trials])
    return _fitted(figures, right, len(right) * weight / weight.sum(), config.room_strength)


def fit_sheets(
    trials: Sequence[DoubtTrial], right: Sequence[Array], config: DoubtTraining
) -> Regression:
    """Fit what tells which buildings are wrong, whose rooms are ``right (R,)`` with so much."""
    return _fitted(_figures(trials, right), _wrong(trials), None, config.sheet_strength)


def _fitted(figures: Array, is_so: Bools, weight: Array | None, strength: float) -> Regression:
    mean, spread = figures.mean(axis=0), figures.std(axis=0) + _LEAST_SPREAD
    model = LogisticRegression(C=strength, max_iter=_MAX_ITERATIONS)
    model.fit(standardised(figures, mean, spread), is_so, sample_weight=weight)
    return Regression(mean, spread, model.coef_[0], float(model.intercept_[0]))


def threshold(probability: Array, wrong: Bools, right_doubted: float) -> float:
    """Return the probability (of N,) above which so large a share of the right ones lies."""
    return float(np.quantile(probability[~wrong], 1.0 - right_doubted))


def held_out_figures(
    trials: Sequence[DoubtTrial], held_out: HeldOut, model: DoubtModel
) -> dict[str, float]:
    """Return how well left-out buildings are told right or wrong, and other pictures from them."""
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
    """Write the model; ``facts`` say how it was made."""
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
