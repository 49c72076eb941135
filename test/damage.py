# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Files with a few bytes changed, for readers that must name what is wrong with them."""


def with_flipped_bytes(good, rng, count, is_cut=False):
    """Return ``good`` with ``count`` random bytes set anew, and cut off anywhere if ``is_cut``."""
    data = bytearray(good)
    for position in rng.integers(0, len(data), count):
        data[position] = rng.integers(256)
    return bytes(data[: rng.integers(1, len(data) + 1)] if is_cut else data)
