# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Freed memory that the process keeps for the arrays of the next update.

The C library returns large arrays to the system as soon as they are freed, and an update frees
some hundred rasters. The next update then gets cleared and newly mapped pages, which took up to a
quarter of its time (notes/benchmarks.md). A library must not change this for the programs that use
it: programs ask for it at their start.
"""

from __future__ import annotations

import os

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # given: parameter numbers of glibc's mallopt
# Given: glibc's maximum; larger arrays are returned to the system as before [bytes].
_LARGEST = 32 * 2**20
# Chosen: freed memory beyond this is returned to the system [bytes].
_KEPT = 256 * 2**20
# Given: settings made by the user take precedence.
_VARIABLES, _TUNABLES = ('MALLOC_TRIM_THRESHOLD_', 'MALLOC_MMAP_THRESHOLD_'), 'GLIBC_TUNABLES'


def keep_freed_memory() -> bool:
    """
    Make the C library keep freed memory for later arrays; return whether it does.

    Changes nothing if the C library is not glibc, or if the environment already configures its
    allocator.
    """
    tuned = os.environ.get(_TUNABLES, '')
    if 'glibc.malloc' in tuned or any(os.environ.get(name) for name in _VARIABLES):
        return False
    import ctypes  # slower to load than the shortest commands are to run

    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return False
    mmap, trim = mallopt(_MMAP_THRESHOLD, _LARGEST), mallopt(_TRIM_THRESHOLD, _KEPT)
    return bool(mmap and trim)
