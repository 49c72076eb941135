# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Details of library errors for one-line messages."""

from __future__ import annotations

from fpnet_core.printable import printable

_LONGEST = 120  # numerical: characters


def detail_of(error: Exception) -> str:
    """Return the printable first line of an error; its type if there is none."""
    line = (str(error).splitlines() or [''])[0].strip()
    return printable(line)[:_LONGEST] or type(error).__name__
