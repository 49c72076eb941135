# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Comparison of two populations of storeys: percentiles, and a two-sample classifier test.

Both are :class:`~fpnet_lab.sim.population.statistics.FloorMeasures`, computed by one function.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.ensemble import HistGradientBoostingClassifier
from sklearn.inspection import permutation_importance
from sklearn.metrics import roc_auc_score
from sklearn.model_selection import StratifiedGroupKFold

from fpnet_lab.sim.population.statistics import FEATURES, FloorMeasures

Floors = Sequence[FloorMeasures]

PERCENTILES = (5, 25, 50, 75, 95)  # numerical

FITTED: dict[str, Callable[[Floors], NDArray[np.float64]]] = {
    'room_area_m2': lambda floors: _pooled(floors, 'areas_m2'),
    'aspect': lambda floors: _pooled(floors, 'aspects'),
    'door_width_m': lambda floors: _pooled(floors, 'door_widths_m'),
}
"""Quantities with percentiles that must agree; their names contain the units."""

QUANTITIES: dict[str, Callable[[Floors], NDArray[np.float64]]] = {
    **FITTED,
    'rectangularity': lambda floors: _pooled(floors, 'rectangularities'),
    'doors_per_room': lambda floors: _pooled(floors, 'doors_per_room'),
    'rooms_per_plan': lambda floors: np.array([len(f.areas_m2) for f in floors], float),
    'doors_of_hub': lambda floors: np.array([f.hub_degree for f in floors], float),
    'cycles_per_plan': lambda floors: np.array([f.cycles for f in floors], float),
    'components_per_plan': lambda floors: np.array([f.components for f in floors], float),
}
"""All compared quantities; the hub is the room with the most doors, usually a corridor."""

FOLDS = 5
REPEATS = 3
"""Numerical: number of different random splits of the few real storeys into folds."""


@dataclass(frozen=True)
class Row:
    """Percentiles of one quantity in both populations, in the order of ``PERCENTILES``."""

    name: str
    generated: tuple[float, ...]
    real: tuple[float, ...]

    @property
    def relative_errors(self) -> tuple[float, ...]:
        """Ratio of generated to real, minus one; infinite if only the real value is 0."""
        return tuple(
            g / r - 1.0 if r else (0.0 if g == r else float('inf'))
            for g, r in zip(self.generated, self.real, strict=True)
        )


@dataclass(frozen=True)
class TwoSample:
    """
    Result of a two-sample test between the regions of two populations.

    ``auc`` is the mean area under the ROC curve over all folds (0.5: indistinguishable),
    ``spread`` its standard deviation; ``importance`` is the loss of AUC if a feature is permuted.
    """

    auc: float
    spread: float
    importance: dict[str, float]


def compare(generated: Floors, real: Floors) -> list[Row]:
    """Return the percentiles of every quantity in both populations."""
    return [
        Row(name, _percentiles(values(generated)), _percentiles(values(real)))
        for name, values in QUANTITIES.items()
    ]


def percentile_errors(rows: Sequence[Row]) -> dict[str, float]:
    """Return relative errors of the fitted quantities, e.g. ``{'room_area_m2_p5': -0.1}``."""
    return {
        f'{row.name}_p{percentile}': error
        for row in rows
        if row.name in FITTED
        for percentile, error in zip(PERCENTILES, row.relative_errors, strict=True)
    }


def two_sample(
    generated: Floors, real: Floors, seed: int = 0, repeats: int = REPEATS
) -> TwoSample:
    """
    Cross-validate a small classifier that separates the regions of the two populations.

    All regions of a storey are in one fold, so that the classifier is tested on unseen storeys.
    The split into folds is repeated ``repeats`` times.
    """
    floors = [*generated, *real]
    features = np.concatenate([floor.regions for floor in floors])
    counts = [len(floor.regions) for floor in floors]
    is_real = np.repeat([0] * len(generated) + [1] * len(real), counts)
    storey = np.repeat(np.arange(len(floors)), counts)
    areas, losses = [], []
    for repeat in range(repeats):
        folds = StratifiedGroupKFold(FOLDS, shuffle=True, random_state=seed + repeat)
        for train, test in folds.split(features, is_real, storey):
            model = _classifier(seed).fit(features[train], is_real[train])
            scores = model.predict_proba(features[test])[:, 1]
            if len(np.unique(is_real[test])) == 1:  # with few storeys, a fold may have one class
                continue
            areas.append(float(roc_auc_score(is_real[test], scores)))
            if repeat == 0:
                losses.append(_importance(model, features[test], is_real[test], seed))
    mean_loss = np.mean(losses, axis=0)
    return TwoSample(
        float(np.mean(areas)),
        float(np.std(areas)),
        {name: float(loss) for name, loss in zip(FEATURES, mean_loss, strict=True)},
    )


def _classifier(seed: int) -> HistGradientBoostingClassifier:
    return HistGradientBoostingClassifier(
        max_iter=50, max_leaf_nodes=8, class_weight='balanced', random_state=seed
    )


def _importance(
    model: HistGradientBoostingClassifier,
    features: NDArray[np.float64],
    is_real: NDArray[np.int64],
    seed: int,
) -> NDArray[np.float64]:
    found = permutation_importance(
        model, features, is_real, scoring='roc_auc', n_repeats=3, random_state=seed
    )
    return np.asarray(found.importances_mean)


def _pooled(floors: Floors, field: str) -> NDArray[np.float64]:
    values: list[Any] = [getattr(floor, field) for floor in floors]
    return np.concatenate(values).astype(float)


def _percentiles(values: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(float(value) for value in np.percentile(values, PERCENTILES))
