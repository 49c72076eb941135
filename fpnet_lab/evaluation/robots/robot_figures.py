# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How often methods are right about real robot maps, and how often they claim what is wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fpnet_lab.evaluation.robots.robot_pairs import BANDS, WHOLE
from fpnet_lab.metrics import share

ALL_BANDS = (WHOLE, *BANDS)

Shares = dict[str, float | int | None]


@dataclass(frozen=True)
class Foreign:
    """What a method said of a robot map on another building's plan."""

    is_same_architect: bool
    is_accepted: bool


@dataclass(frozen=True)
class Outcome:
    """
    What one method said of one robot map.

    ``is_right`` and ``is_claimed`` are of its own plan; ``foreign`` holds plans of other
    buildings, none where the method did not meet any.
    """

    band: str
    building: str
    is_distorted: bool
    is_right: bool
    is_accepted: bool
    foreign: tuple[Foreign, ...] = ()


def robot_figures(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return ``bands``, ``bands_undistorted`` and per building ``buildings``."""
    names = sorted({o.building for o in outcomes})
    return {
        'bands': by_band(outcomes),
        'bands_undistorted': by_band([o for o in outcomes if not o.is_distorted]),
        'buildings': {
            name: by_band([o for o in outcomes if o.building == name]) for name in names
        },
    }


def by_band(outcomes: Sequence[Outcome]) -> dict[str, Shares]:
    """
    Return the figures of each band.

    On their own plan ``right``, ``claimed_right`` and ``wrong_and_claimed`` are shares of all
    ``pairs``; ``foreign_claimed`` is the share of the ``foreign_pairs`` of a map and another
    building's plan that are claimed, in all, on plans of any architect but the map's
    (``foreign_random_claimed``), and on those by the same one
    (``foreign_same_architect_claimed``). A share of nothing is None.
    """
    return {band: _shares([o for o in outcomes if o.band == band]) for band in ALL_BANDS}


def _shares(outcomes: Sequence[Outcome]) -> Shares:
    foreign = [each for o in outcomes for each in o.foreign]
    same = [each.is_accepted for each in foreign if each.is_same_architect]
    other = [each.is_accepted for each in foreign if not each.is_same_architect]
    return {
        'right': share(o.is_right for o in outcomes),
        'claimed_right': share(o.is_accepted and o.is_right for o in outcomes),
        'wrong_and_claimed': share(o.is_accepted and not o.is_right for o in outcomes),
        'foreign_claimed': share(same + other),
        'foreign_random_claimed': share(other),
        'foreign_same_architect_claimed': share(same),
        'pairs': len(outcomes),
        'foreign_pairs': len(foreign),
        'foreign_same_architect_pairs': len(same),
    }
