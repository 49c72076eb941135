# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Fitting what doubts a building that was found: first which rooms are right, then which are wrong.

The second is fitted to what the first says of rooms that it has not learned from. All of it is
measured with buildings left out, and the probability from which on a building is doubted is
chosen there.
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
from fpnet_lab.training.sheets_read import COMPARED_CELLS, read_from_file

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

FIRST_SEED = 4000
"""
Numerical: of the sheets to learn from: seeds of the tune half that the benchmark does not reach.
"""

_SAME_IOU = 0.5  # given: of a room found and a true one, as the benchmark has it
_LEAST_SPREAD = 1e-3  # numerical: of evidence that hardly varies
_MAX_ITERATIONS = 2000  # numerical


@dataclass(frozen=True, eq=False)
class DoubtTrial:
    """
    A sheet that was read: evidence ``rooms (R, D)`` and ``whole (F,)``, and the truth.

    Its rooms are ``right (R,)``; ``f1`` is that of its rooms. Sheets of one ``seed`` share a
    building.
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


def gather_trials(
    folder: Path,
    seeds: Sequence[int],
    config: SegmentationConfig,
    workers: int = 1,
    on_sheet: Callable[[float], None] = lambda _: None,
) -> list[DoubtTrial]:
    """Return the trials of all kinds of sheets; what ``folder`` holds is taken over."""
    tasks = {f'{kind.value}-{seed}': (seed, kind) for seed, kind in product(seeds, SheetKind)}
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
    config: SegmentationConfig, drawn: tuple[int, SheetKind]
) -> tuple[DoubtTrial, ...]:
    """Read a sheet from a file as a user's; none where it is refused or has no rooms."""
    sheet = draw_sheet(*drawn)
    read = read_from_file(sheet, config)
    if read is None or read.found.seen is None or not read.found.segmentation.rooms:
        return ()
    evidence = evidence_of(read.found, config)
    H_plan_page = read.found.H_plan_pixel @ read.H_pixel_page
    truth = compared(sheet, read.found.segmentation, H_plan_page, COMPARED_CELLS)
    right = best_overlap(truth.found, truth.true, len(evidence.rooms)) > _SAME_IOU
    kind = sheet.kind.value
    return (DoubtTrial(kind, sheet.seed, truth.f1, evidence.rooms, right, evidence.whole),)


def fit_doubts(
    trials: Sequence[DoubtTrial],
    config: DoubtTraining,
    on_fold: Callable[[float], None] = lambda _: None,
) -> tuple[DoubtModel, HeldOut]:
    """
    Fit the model to all trials, its threshold to what was held out, and return both.

    Raises
    ------
    FpnetError
        If there are fewer buildings than folds, or all of them are right or wrong.
    """
    seeds = np.array([trial.seed for trial in trials])
    wrong = _wrong(trials)
    if len(np.unique(seeds)) < config.folds or wrong.all() or not wrong.any():
        raise FpnetError('too few sheets to learn from: it takes right and wrong ones')
    held_out = left_out(trials, config, on_fold)
    level = threshold(held_out.wrong, wrong, config.right_doubted)
    rooms = fit_rooms(trials, config)
    return DoubtModel(rooms, fit_sheets(trials, held_out.right, config), level), held_out


def left_out(
    trials: Sequence[DoubtTrial],
    config: DoubtTraining,
    on_fold: Callable[[float], None] = lambda _: None,
) -> HeldOut:
    """Return what is said of each trial by models that have not seen its building."""
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
    return HeldOut(right, wrong)


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
    trials: Sequence[DoubtTrial], held_out: HeldOut, doubted_from: float
) -> dict[str, float]:
    """Return how well left-out buildings are told right or wrong."""
    wrong, p = _wrong(trials), held_out.wrong
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
    """Write the model; ``facts`` say how it was made."""
    stored = {
        'doubted_from': round(model.doubted_from, 6),
        'rooms': _stored(model.right_room, ROOM_FIGURES),
        'sheets': _stored(model.wrong_sheet, SHEET_FIGURES),
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
