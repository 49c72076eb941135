# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a library said of a damaged file, fit for a line that a person reads."""

from __future__ import annotations

from fpnet_core.printable import printable

_LONGEST = 120  # numerical: letters


def detail_of(error: Exception) -> str:
    """Return the first line of an error that can be printed; its kind if there is none."""
    line = (str(error).splitlines() or [''])[0].strip()
    return printable(line)[:_LONGEST] or type(error).__name__
