# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Conversion of a site to the localizer's storeys, and storey priors from hints."""

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
"""Physical: error of barometers and of odometry over a few storeys; storeys are 3 m apart."""

_RISE_SIGMA_M = 0.5
"""Physical: error of odometry and of stated elevations over one ride."""

_LEAST = 1e-3
"""Chosen: smallest weight of a storey, relative to the best one."""

_BY_LINK = 0.9
"""Chosen: probability that a robot leaves a storey by a lift or stairs of the site."""

_NEAR_M = 5.0
"""Chosen: distance at which a link is half as probable as one at the robot's position."""


def storey_plans(site: Site, config: FpnetConfig) -> list[StoreyPlan]:
    """Return the storeys' plans; without a stated scale, the scale policy is ``unknown``."""
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
    Return the storey that a message names: by its name, with or without building, or its level.

    Raises
    ------
    HintError
        If not exactly one storey matches.
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
    Return the storeys' weights after a hint that names one, for example from a lift.

    Raises
    ------
    HintError
        If not exactly one storey matches.
    """
    return weights_of_word(storey_named(site, said).name, site.names)


def weights_of_elevation(
    site: Site, elevation_m: float, sigma_m: float = _ELEVATION_SIGMA_M
) -> dict[str, float]:
    """
    Return the storeys' weights for a height of the floor from a barometer or odometry.

    Raises
    ------
    HintError
        If the height is not finite, or a storey's elevation is unknown.
    """
    if not np.isfinite(elevation_m):
        raise HintError(f'an elevation of {elevation_m} m is not valid; send one in metres')
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

    Linked storeys share most of the weight; lifts and stairs near the robot count more.

    Parameters
    ----------
    site : the site
    left : name of the storey; it stays possible, as lift doors may close and open without a ride
    xy : (2,) last position of the robot in that storey's plan [m]; None if unknown
    rise_m : change of height since [m]; None if unknown
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
