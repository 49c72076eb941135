# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A site as the localizer takes it, and what is said of its storeys before looking."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.errors import HintError
from fpnet_core.localizer import StoreyPlan
from fpnet_core.localizer.storeys import weights_of_word
from fpnet_core.sites.site import LinkKind, Site, Storey

_ELEVATION_SIGMA_M = 1.0
"""Physical: barometers and odometry over a few storeys err by about this; storeys are 3 m."""

_RISE_SIGMA_M = 0.5
"""Physical: what odometry that sees the ride, and stated elevations, err by in one ride."""

_LEAST = 1e-3
"""Chosen: a storey that nothing speaks for is as improbable, beside the best one."""

_BY_LINK = 0.9
"""Chosen: probability that who leaves a storey takes a lift or stairs that the site knows."""

_NEAR_M = 5.0
"""Chosen: a link so far off is half as probable to be taken as one where the robot is."""


def storey_plans(site: Site, config: FpnetConfig) -> list[StoreyPlan]:
    """Return the storeys' drawings; the scale of those that state none is searched as unknown."""
    is_set = 'scale_policy' in config.localizer.model_fields_set
    return [
        StoreyPlan(
            storey.name,
            storey.plan.grid,
            storey.plan.estimate,
            None if storey.plan.scale.is_known or is_set else 'unknown',
            storey.plan.segmented(config.segmentation),
        )
        for storey in site.storeys
    ]


def storey_named(site: Site, said: str) -> Storey:
    """
    Return the storey that a message means: by its name, its level or its elevation's place.

    Raises
    ------
    HintError
        If no storey or more than one is called so.
    """
    said = said.strip()
    found = [s for s in site.storeys if said in (s.name, s.name.rpartition('/')[2])]
    found = found or [s for s in site.storeys if said == str(s.level)]
    if len(found) != 1:
        what = 'no storey is' if not found else f'{len(found)} storeys are'
        raise HintError(f'{what} called {said!r}; expected one of {", ".join(site.names)}')
    return found[0]


def weights_of_level(site: Site, said: str) -> dict[str, float]:
    """
    Return the storeys' weights where somebody, as a lift, has named one.

    Raises
    ------
    HintError
        If no storey or more than one is called so.
    """
    return weights_of_word(storey_named(site, said).name, site.names)


def weights_of_elevation(
    site: Site, elevation_m: float, sigma_m: float = _ELEVATION_SIGMA_M
) -> dict[str, float]:
    """
    Return the storeys' weights where a barometer or odometry knows the height of the floor.

    Raises
    ------
    HintError
        If the height is no number, or a storey's elevation is not known.
    """
    if not np.isfinite(elevation_m):
        raise HintError(f'an elevation of {elevation_m} m is no height; send one in metres')
    if missing := [s.name for s in site.storeys if s.elevation_m is None]:
        raise HintError(f'storey {missing[0]!r} has no elevation; add it to the site')
    heights = np.array([s.elevation_m for s in site.storeys], dtype=np.float64)
    off = (heights - elevation_m) ** 2 / (2.0 * sigma_m**2)
    weights = np.maximum(np.exp(off.min() - off), _LEAST)
    return dict(zip(site.names, weights.tolist(), strict=True))


def weights_after_leaving(
    site: Site,
    left: str,
    xy: NDArray[np.float64] | None = None,
    rise_m: float | None = None,
) -> dict[str, float]:
    """
    Return the storeys' weights for a robot that has left one.

    Storeys that lifts and stairs lead to share most of it, those by the links that it was near.

    Parameters
    ----------
    site : the site
    left : name of the storey; it stays possible: doors open and close where nobody gets out
    xy : (2,) where the robot was in that storey's plan [m]; None: unknown
    rise_m : how far it went up since [m]; None: unknown
    """
    weights = dict.fromkeys(site.names, (1.0 - _BY_LINK) / len(site.storeys))
    links = site.linked(left)
    nearness = np.array([_nearness(link.at[left], xy) for link in links])
    for link, share in zip(links, nearness / max(nearness.sum(), _LEAST), strict=True):
        stops = link.at if link.kind is LinkKind.LIFT else [s for s in link.at if s != left]
        for stop in stops:
            weights[stop] += _BY_LINK * float(share) / len(stops)
    start_m = site.storey(left).elevation_m
    if rise_m is None or start_m is None:
        return weights
    heights = weights_of_elevation(site, start_m + rise_m, _RISE_SIGMA_M)
    return _product(weights, heights)


def _nearness(stop: NDArray[np.float64], xy: NDArray[np.float64] | None) -> float:
    if xy is None:
        return 1.0
    return float(0.5 ** (np.linalg.norm(stop - xy) / _NEAR_M))


def _product(first: Mapping[str, float], second: Mapping[str, float]) -> dict[str, float]:
    return {name: weight * second[name] for name, weight in first.items()}
