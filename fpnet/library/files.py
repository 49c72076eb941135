# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drawings on disk for a library, and its proposals as a site."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from fpnet.library.library import LibraryPlan, Proposal, plan_of
from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.opening import known_suffixes
from fpnet_core.drawings.plan_files import picture_path
from fpnet_core.drawings.read import read_plan
from fpnet_core.errors import FpnetError, LibraryError
from fpnet_core.io.maps import YAML_SUFFIXES, image_of, map_yamls
from fpnet_core.localizer.maps import cut_of
from fpnet_core.sites import Site, Storey


def plan_files(paths: Iterable[Path]) -> list[Path]:
    """
    Return floorplan files sorted by name; folders are searched recursively.

    Files that belong to a map_server YAML by their name, its image or the plot of ``fpnet plan``,
    are not floorplans of their own. A YAML that is no map is ignored.

    Raises
    ------
    LibraryError
        If a path is missing, or a folder holds no floorplan.
    """
    found: list[Path] = []
    for path in paths:
        if path.is_dir():
            found += _in_folder(path)
        elif path.exists():
            found.append(path)
        else:
            raise LibraryError(f'{path} does not exist; give floorplans or folders')
    return sorted(set(found))


def _in_folder(folder: Path) -> list[Path]:
    files = sorted(path for path in folder.rglob('*') if path.is_file())
    maps = map_yamls(files)
    stems = {path.with_suffix('') for path in maps}
    of_maps = {
        each.resolve() for path in maps for each in (image_of(path), picture_path(path)) if each
    }
    drawings = [
        path
        for path in files
        if path.suffix.lower() in known_suffixes()
        and path.resolve() not in of_maps
        and path.with_suffix('') not in stems
    ]
    if not (maps or drawings):
        suffixes = sorted({*known_suffixes(), *YAML_SUFFIXES})
        raise LibraryError(f'{folder} holds no floorplan; expected files with suffixes {suffixes}')
    return [*maps, *drawings]


def share_of(paths: Sequence[Path], share: str) -> tuple[list[Path], int]:
    """
    Return the share ``K/N`` of ``paths``, and the number of its first shard.

    Raises
    ------
    LibraryError
        If ``share`` is malformed.
    """
    first, _, last = share.partition('/')
    if not (first.isdigit() and last.isdigit() and 1 <= int(first) <= int(last)):
        raise LibraryError(f'--share {share}: expected K/N, e.g. 3/10 for the third of ten shares')
    number = int(first) - 1
    return list(paths[number :: int(last)]), 2 * number  # shards of stated and other scales


def read_library_plan(path: Path, config: FpnetConfig) -> LibraryPlan:
    """
    Read a floorplan as a library entry.

    Raises
    ------
    FpnetError
        If it cannot be read, or holds no room.
    """
    reading = read_plan(path, config=config)
    cut = cut_of(reading, config)
    return plan_of(str(path.resolve()), cut.segmentation, cut.scale)


def proposed_site(proposals: Sequence[Proposal], config: FpnetConfig) -> Site:
    """
    Return the proposals of a library as the storeys of a site, each named by its file.

    Raises
    ------
    FpnetError
        If there is no proposal, or a drawing can no longer be read; the message names it.
    """
    if not proposals:
        raise LibraryError('too little was observed to propose a floorplan: no doors or corners')
    storeys = []
    for proposal in proposals:
        try:
            plan = read_plan(Path(proposal.path), config=config)
        except FpnetError as error:
            raise LibraryError(f'{error}; build the library again') from error
        storeys.append(Storey(proposal.path, plan))
    return Site('library', tuple(storeys))
