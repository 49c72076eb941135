# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checked, copied and read-only arrays of frozen dataclasses."""

from __future__ import annotations

from typing import Any, TypeGuard, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Scalar = TypeVar('Scalar', bound=np.generic)
Shape = tuple[int | None, ...]
"""Lengths of the axes; None: any."""


def frozen_array(
    value: ArrayLike, dtype: Any, shape: Shape, what: str, is_finite: bool = True
) -> NDArray[Any]:
    """
    Return a read-only copy of ``dtype`` in C order; an array that is one already is not copied.

    Raises
    ------
    ValueError
        Names ``what`` if its shape is wrong, or if it holds NaN or infinity but must be finite.
    """
    array = value if _is_frozen(value, dtype) else np.array(value, dtype=dtype, order='C')
    matches = array.ndim == len(shape) and all(
        want is None or want == got for want, got in zip(shape, array.shape, strict=True)
    )
    if not matches:
        raise ValueError(f'{what}: expected shape {shape}, got {array.shape}')
    if is_finite and array.dtype.kind == 'f' and not np.isfinite(array).all():
        raise ValueError(f'{what}: holds NaN or infinity')
    array.setflags(write=False)
    return array


def _is_frozen(value: ArrayLike, dtype: Any) -> TypeGuard[NDArray[Any]]:
    """Return whether an array is such a copy already: it owns its memory and is read-only."""
    return (
        type(value) is np.ndarray
        and value.dtype == dtype
        and value.base is None
        and not value.flags.writeable
        and value.flags.c_contiguous
    )


def unwritable(values: NDArray[Scalar]) -> NDArray[Scalar]:
    """Return a read-only view in C order: compiled loops then see one array type."""
    view = np.ascontiguousarray(values).view()
    view.setflags(write=False)
    return view


def each_unwritable(*arrays: NDArray[Any]) -> list[NDArray[Any]]:
    """Return :func:`unwritable` of each array."""
    return [unwritable(array) for array in arrays]


def freeze_field(owner: object, name: str, dtype: Any, shape: Shape) -> None:
    """Replace a field of a frozen dataclass by its :func:`frozen_array`."""
    what = f'{type(owner).__name__}.{name}'
    array = frozen_array(getattr(owner, name), dtype, shape, what)
    object.__setattr__(owner, name, array)
