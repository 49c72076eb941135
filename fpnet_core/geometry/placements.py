# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Placements of a submap on a plan: the value that all steps of the search pass on.

Thousands are proposed, then ranked, refined, scored and given probabilities. Each step takes
:class:`Placements` and returns them with one more column filled.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, Self, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fpnet_core.frozen import freeze_field, frozen_array
from fpnet_core.geometry.distinct import first_distinct
from fpnet_core.geometry.polar import heading_of, scale_of, stretch_of
from fpnet_core.geometry.transforms import Affine2D

Array = NDArray[np.float64]
Index = NDArray[np.int64] | NDArray[np.bool_] | slice


@dataclass(frozen=True, eq=False)
class Placement:
    """
    Placement of a submap on a plan.

    ``A_plan_submap`` maps submap metres to plan metres. ``score`` in [0, 1] is the agreement of
    the two maps, NaN until it is computed. ``cov (3, 3)`` is over x, y [m] and yaw [rad] of the
    submap's origin in ``plan``; it covers the alignment error only, not errors of the drawing,
    and is zero until it is estimated. ``probability`` is the posterior of this placement among
    all placements and the null hypothesis, NaN until it is computed.
    """

    A_plan_submap: Affine2D
    score: float = np.nan
    cov: Array = field(default_factory=lambda: np.zeros((3, 3)))
    probability: float = np.nan

    def __post_init__(self) -> None:
        """Check and freeze the covariance."""
        freeze_field(self, 'cov', np.float64, (3, 3))


@dataclass(frozen=True, eq=False, init=False)
class Placements:
    """
    ``C`` placements of one submap on one plan; best first once they are ranked.

    Parameters
    ----------
    linear : (C, 2, 2) float64
    translation : (C, 2) float64
        ``p_plan = linear @ p_submap + translation`` [m].
    score : (C,) float64
        As :attr:`Placement.score`; None gives NaN.
    cov : (C, 3, 3) float64
        As :attr:`Placement.cov`; None gives zeros.
    probability : (C,) float64
        As :attr:`Placement.probability`; None gives NaN.

    Raises
    ------
    ValueError
        If a shape is wrong. Values are not checked: a proposal may be NaN and ranks last.
    """

    linear: Array
    translation: Array
    score: Array
    cov: Array
    probability: Array

    def __init__(
        self,
        linear: ArrayLike,
        translation: ArrayLike,
        score: ArrayLike | None = None,
        cov: ArrayLike | None = None,
        probability: ArrayLike | None = None,
    ) -> None:
        count = len(np.asarray(linear))
        unknown = np.full(count, np.nan)
        columns = {
            'linear': (linear, (count, 2, 2)),
            'translation': (translation, (count, 2)),
            'score': (unknown if score is None else score, (count,)),
            'cov': (np.zeros((count, 3, 3)) if cov is None else cov, (count, 3, 3)),
            'probability': (unknown if probability is None else probability, (count,)),
        }
        for name, (value, shape) in columns.items():
            what = f'Placements.{name}'
            array = frozen_array(value, np.float64, shape, what, is_finite=False)
            object.__setattr__(self, name, array)

    @classmethod
    def of(cls, placed: Iterable[Affine2D | Placement]) -> Self:
        """Collect placements; a bare ``A_plan_submap`` gets the defaults of :class:`Placement`."""
        each = [p if isinstance(p, Placement) else Placement(p) for p in placed]
        return cls(
            np.array([p.A_plan_submap.linear for p in each]).reshape(-1, 2, 2),
            np.array([p.A_plan_submap.translation for p in each]).reshape(-1, 2),
            [p.score for p in each],
            np.array([p.cov for p in each]).reshape(-1, 3, 3),
            [p.probability for p in each],
        )

    @classmethod
    def empty(cls) -> Self:
        """Return zero placements."""
        return cls.of(())

    def __len__(self) -> int:
        """Return the number of placements."""
        return len(self.linear)

    def __getitem__(self, index: SupportsIndex) -> Placement:
        """Return one placement; raise ValueError if it is singular or not finite."""
        return Placement(
            Affine2D(self.linear[index], self.translation[index]),
            float(self.score[index]),
            self.cov[index],
            float(self.probability[index]),
        )

    def __iter__(self) -> Iterator[Placement]:
        """Iterate over the placements in order."""
        return (self[index] for index in range(len(self)))

    def take(self, index: Index) -> Placements:
        """Return the placements at ``index``, in that order."""
        return Placements(*(column[index] for column in self._columns))

    def joined(self, other: Placements) -> Placements:
        """Return these placements followed by ``other``."""
        pairs = zip(self._columns, other._columns, strict=True)
        return Placements(*(np.concatenate(pair) for pair in pairs))

    @property
    def _columns(self) -> tuple[Array, ...]:
        return self.linear, self.translation, self.score, self.cov, self.probability

    @property
    def matrix(self) -> Array:
        """Homogeneous matrices (C, 3, 3)."""
        m = np.tile(np.eye(3), (len(self), 1, 1))
        m[:, :2, :2] = self.linear
        m[:, :2, 2] = self.translation
        return m

    @property
    def scale(self) -> Array:
        """Mean scales (C,): plan metres per submap metre."""
        return scale_of(self.linear)

    @property
    def heading(self) -> Array:
        """Rotations (C,) [rad], as :attr:`Affine2D.heading`."""
        return heading_of(self.linear)

    @property
    def stretch(self) -> Array:
        """Symmetric stretches (C, 2, 2) in the plan's axes, as :attr:`Affine2D.stretch`."""
        return stretch_of(self.linear)

    def apply(self, points: ArrayLike) -> Array:
        """Return the ``points (P, 2)`` of the submap mapped by each placement, ``(C, P, 2)``."""
        placed = np.einsum('cij,kj->cki', self.linear, np.asarray(points, dtype=np.float64))
        return np.asarray(placed + self.translation[:, None], dtype=np.float64)

    def __matmul__(self, other: Any) -> Placements:
        """
        Return ``A_plan_submap @ A_submap_x``: the placements of another frame of the submap.

        Scores and probabilities are kept; covariances are moved to that frame's origin.
        """
        if not isinstance(other, Affine2D):
            return NotImplemented
        lever = np.einsum('cij,j->ci', self.linear, other.translation)
        jacobian = np.tile(np.eye(3), (len(self), 1, 1))
        jacobian[:, 0, 2], jacobian[:, 1, 2] = -lever[:, 1], lever[:, 0]
        return Placements(
            np.einsum('cij,jk->cik', self.linear, other.linear),
            lever + self.translation,
            self.score,
            jacobian @ self.cov @ jacobian.transpose(0, 2, 1),
            self.probability,
        )

    def __rmatmul__(self, other: Any) -> Placements:
        """
        Return ``A_x_plan @ A_plan_submap``: the placements in another frame of the plan.

        Scores and probabilities are kept; covariances are transformed, yaw as by a similarity.
        """
        if not isinstance(other, Affine2D):
            return NotImplemented
        jacobian = np.eye(3)
        jacobian[:2, :2] = other.linear
        return Placements(
            np.einsum('ij,cjk->cik', other.linear, self.linear),
            np.einsum('ij,cj->ci', other.linear, self.translation) + other.translation,
            self.score,
            jacobian @ self.cov @ jacobian.T,
            self.probability,
        )

    def distinct(self, points: ArrayLike, distance_m: float, limit: int) -> NDArray[np.int64]:
        """
        Return the indices of placements that differ from every better one that was kept.

        Two differ if they map ``points (P, 2)`` of the submap more than ``distance_m`` apart on
        average. The placements must be ranked, best first. At most ``limit`` indices.
        """
        x, y = np.moveaxis(self.apply(points), -1, 0)

        def is_same(index: int, others: NDArray[np.int64]) -> NDArray[np.bool_]:
            moved = np.hypot(x[others] - x[index], y[others] - y[index]).sum(axis=1)
            return np.asarray(moved <= distance_m * x.shape[1])

        return first_distinct(len(self), is_same, limit)
