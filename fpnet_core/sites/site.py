# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Data model of a site: storeys of one or more buildings, and lifts and stairs between them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from fpnet_core.drawings.types import Reading
from fpnet_core.errors import SiteError
from fpnet_core.frozen import freeze_field
from fpnet_core.geometry import SE2


class LinkKind(StrEnum):
    """Type of a connection between storeys."""

    LIFT = 'lift'
    STAIRS = 'stairs'


@dataclass(frozen=True, eq=False)
class NamedDoor:
    """A named door: ``ends (2, 2)`` of its opening in the storey's plan [m]."""

    name: str
    ends: NDArray[np.float64]

    def __post_init__(self) -> None:
        """Check the shape of the opening."""
        freeze_field(self, 'ends', np.float64, (2, 2))


@dataclass(frozen=True, eq=False)
class Storey:
    """
    One storey of a site.

    Parameters
    ----------
    name
        Name, unique in the site.
    plan
        Its parsed drawing.
    building
        Name of the building; empty if the site is a single building.
    level
        Level number; larger is higher.
    elevation_m
        Height of its floor; None if unknown.
    T_site_plan
        Transform from its plan to a frame shared by storeys of the building; None if unknown.
    doors
        Named doors.
    """

    name: str
    plan: Reading
    building: str = ''
    level: int = 0
    elevation_m: float | None = None
    T_site_plan: SE2 | None = None
    doors: tuple[NamedDoor, ...] = ()


@dataclass(frozen=True, eq=False)
class Link:
    """A lift or stairs: ``at`` maps names of storeys to positions ``(2,)`` in their plans [m]."""

    name: str
    kind: LinkKind
    at: Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Site:
    """
    Storeys and the links between them.

    Raises
    ------
    SiteError
        If there is no storey, two have the same name, or a link names an unknown storey.
    """

    name: str
    storeys: tuple[Storey, ...]
    links: tuple[Link, ...] = field(default=())

    def __post_init__(self) -> None:
        """Check that names are unique and that links connect known storeys."""
        if not self.storeys:
            raise SiteError(f'site {self.name}: there is no storey; add at least one')
        counts = Counter(self.names)
        if twice := [name for name, count in counts.items() if count > 1]:
            raise SiteError(
                f'site {self.name}: {counts[twice[0]]} storeys are called {twice[0]!r}; use '
                'unique names, or name their buildings'
            )
        for link in self.links:
            self._check(link)

    def _check(self, link: Link) -> None:
        for name in link.at:
            if name not in self.names:
                raise SiteError(
                    f'site {self.name}: {link.kind.value} {link.name!r} stops at {name!r}, which '
                    f'is not a storey; expected one of {", ".join(self.names)}'
                )
        if len(link.at) < 2:
            raise SiteError(
                f'site {self.name}: {link.kind.value} {link.name!r} stops at '
                f'{len(link.at)} storey; a link needs two or more'
            )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all storeys."""
        return tuple(storey.name for storey in self.storeys)

    def storey(self, name: str) -> Storey:
        """
        Return a storey by its name.

        Raises
        ------
        SiteError
            If there is no such storey.
        """
        for storey in self.storeys:
            if storey.name == name:
                return storey
        raise SiteError(
            f'site {self.name} has no storey {name!r}; expected one of {", ".join(self.names)}'
        )

    def linked(self, name: str) -> tuple[Link, ...]:
        """Return the lifts and stairs that stop at a storey."""
        return tuple(link for link in self.links if name in link.at)
