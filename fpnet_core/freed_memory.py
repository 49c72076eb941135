# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Freed memory that stays with the process, for the arrays of the next tick.

The C library hands large arrays back to the system as soon as they are freed, and a tick frees
some hundred rasters. The next one gets each page of them cleared and mapped anew, which took it up
to a quarter of its time (docs/benchmarks.md). A library must not decide this for whoever uses it:
programs ask for it where they start.
"""

from __future__ import annotations

import os

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # given: what glibc's mallopt calls them
# Given: glibc takes no larger one; larger arrays are handed back as before [bytes].
_LARGEST = 32 * 2**20
# Chosen: freed memory beyond so much is handed back [bytes].
_KEPT = 256 * 2**20
# Given: where somebody has said otherwise, that holds.
_VARIABLES, _TUNABLES = ('MALLOC_TRIM_THRESHOLD_', 'MALLOC_MMAP_THRESHOLD_'), 'GLIBC_TUNABLES'


def keep_freed_memory() -> bool:
    """
    Have the C library keep freed memory for later arrays; returns whether it does.

    Nothing changes with another C library than glibc, or where the environment says how memory is
    to be had.
    """
    tuned = os.environ.get(_TUNABLES, '')
    if 'glibc.malloc' in tuned or any(os.environ.get(name) for name in _VARIABLES):
        return False
    import ctypes  # takes longer to load than the shortest commands do

    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return False
    mmap, trim = mallopt(_MMAP_THRESHOLD, _LARGEST), mallopt(_TRIM_THRESHOLD, _KEPT)
    return bool(mmap and trim)
