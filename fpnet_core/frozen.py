# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Arrays of frozen values: checked, copied and marked read-only."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Shape = tuple[int | None, ...]
"""Lengths of the axes; None where any will do."""


def frozen_array(
    value: ArrayLike, dtype: Any, shape: Shape, what: str, is_finite: bool = True
) -> NDArray[Any]:
    """
    Return a read-only copy of ``dtype``, in C order.

    Raises
    ------
    ValueError
        Naming ``what`` is wrong: another shape, or values that are not finite but ought to be.
    """
    array = np.array(value, dtype=dtype, order='C')
    matches = array.ndim == len(shape) and all(
        want is None or want == got for want, got in zip(shape, array.shape, strict=True)
    )
    if not matches:
        raise ValueError(f'{what}: expected shape {shape}, got {array.shape}')
    is_float = np.issubdtype(array.dtype, np.floating)
    if is_finite and is_float and not np.isfinite(array).all():
        raise ValueError(f'{what}: holds NaN or infinity')
    array.setflags(write=False)
    return array


def freeze_field(owner: object, name: str, dtype: Any, shape: Shape) -> None:
    """Replace a field of a frozen dataclass by :func:`frozen_array` of it."""
    what = f'{type(owner).__name__}.{name}'
    array = frozen_array(getattr(owner, name), dtype, shape, what)
    object.__setattr__(owner, name, array)
