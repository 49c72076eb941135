# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Shares of right and of accepted results on real robot maps."""

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
    """Result of a method for a robot map on another building's plan."""

    is_same_architect: bool
    is_accepted: bool


@dataclass(frozen=True)
class Outcome:
    """
    Result of one method for one robot map.

    ``is_right`` and ``is_accepted`` are for the correct plan; ``foreign`` holds the results on
    plans of other buildings, empty if the method was not run on any.
    """

    band: str
    building: str
    is_distorted: bool
    is_right: bool
    is_accepted: bool
    foreign: tuple[Foreign, ...] = ()


def robot_figures(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return ``bands``, ``bands_undistorted`` and, for each building, ``buildings``."""
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

    On the correct plan, ``right``, ``claimed_right`` and ``wrong_and_claimed`` are shares of all
    ``pairs``; ``foreign_claimed`` is the accepted share of the ``foreign_pairs`` of a map and
    another building's plan: all of them, those by architects other than the map's
    (``foreign_random_claimed``), and those by the same architect
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
