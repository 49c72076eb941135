# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Where pages state different figures for one thing."""

from collections.abc import Sequence

from fpnet_lab.evaluation.published.figures import Stated


def contradictions(on_pages: Sequence[Stated]) -> list[str]:
    """Return a line for each name that has different figures on different places."""
    by_name: dict[str, list[Stated]] = {}
    for each in on_pages:
        by_name.setdefault(each.name, []).append(each)
    return [
        f'{name}: ' + '; '.join(f'{each.page.name} states {each.text!r}' for each in places)
        for name, places in by_name.items()
        if len({each.text for each in places}) > 1
    ]
