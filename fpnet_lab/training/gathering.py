# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Common types for generating training data: amounts, tasks and columns of samples."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Self, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

Source = TypeVar('Source')


@dataclass(frozen=True)
class Counts:
    """Numbers of samples by kind: the fields of a subclass, all int."""

    def scaled(self, share: float) -> Self:
        """Return the counts multiplied by ``share``, at least one of each kind."""
        return type(self)(**{kind: max(1, round(share * n)) for kind, n in vars(self).items()})


@dataclass(frozen=True)
class MapTask(Generic[Source]):
    """A training map, its building, and the seed of its random choices."""

    make: Callable[[np.random.Generator], Source]
    building: str
    kind: str
    is_real: bool
    seed: tuple[int, ...]

    @property
    def name(self) -> str:
        """Unique name among the tasks of all runs."""
        return '-'.join(map(str, self.seed))

    def begun(self) -> tuple[Source, np.random.Generator]:
        """Return the map, and its random generator for later steps."""
        cv2.setNumThreads(1)  # several processes share the cores
        rng = np.random.default_rng(self.seed)
        return self.make(rng), rng


class Columns:
    """Samples as columns: fields of a frozen dataclass, arrays with one row per sample."""

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(next(iter(vars(self).values())))

    def where(self, chosen: Any) -> Self:
        """Return the ``chosen`` samples: a mask (N,) or indices."""
        return type(self)(**{name: column[chosen] for name, column in vars(self).items()})

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return the samples of all ``parts``, at least one, in order."""
        columns: dict[str, NDArray[Any]] = {
            name: np.concatenate([vars(part)[name] for part in parts]) for name in vars(parts[0])
        }
        return cls(**columns)
