# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet library``: find the floorplan of the right building among many."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fpnet.cli import common
from fpnet.cli.exits import NO_ANSWER
from fpnet.cli.progress import progress
from fpnet_core.printable import printable

if TYPE_CHECKING:
    from fpnet.api.values import Match, RobotMap
    from fpnet.library import LibraryPlan, Proposal
    from fpnet_core.config import FpnetConfig

app = typer.Typer(help='Find the right floorplan among many.', no_args_is_help=True)


@app.callback()
def _group() -> None:
    """
    Find the right floorplan among many.

    Example: fpnet library build plans/ --out plans.lib
    """


@app.command('build')
def build(
    plans: Annotated[
        list[Path], typer.Argument(metavar='PLANS', help='Floorplans, or folders of them.')
    ],
    out: Annotated[Path, typer.Option('--out', metavar='DIR', help='Folder of the library.')],
    share: Annotated[
        str, typer.Option('--share', metavar='K/N', help='Process only the K-th of N shares.')
    ] = '1/1',
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
) -> None:
    """
    Build a library: segment floorplans and index their doors, corners and walls.

    Plans that cannot be read are reported and skipped. Several machines may each build a share
    into one folder. The library stores the paths of the drawings, not the drawings.

    Example: fpnet library build plans/ --out plans.lib

    Example: fpnet library build plans/ --out plans.lib --share 3/10
    """
    tree = common.load(config, settings)
    from fpnet.library import PlanLibrary
    from fpnet.library.files import plan_files, read_library_plan, share_of
    from fpnet_core.errors import FpnetError

    files, first = share_of(plan_files(plans), share)
    read: list[LibraryPlan] = []
    with progress('reading', total=len(files)) as advance:
        for path in files:
            try:
                read.append(read_library_plan(path, tree))
            except FpnetError as error:
                typer.echo(printable(f'skipped: {error}'), err=True)
            advance(1.0)
    library = PlanLibrary.of(read)
    library.save(out, first)
    kilobytes = library.size_bytes / len(library) / 1000.0
    typer.echo(f'{out}: {len(library)} of {len(files)} floorplans, {kilobytes:.1f} kB each')


@app.command('find')
def find(
    library: Annotated[Path, typer.Argument(metavar='LIBRARY', help='Folder written by build.')],
    submap: Annotated[
        Path,
        typer.Option(
            '--submap', metavar='FILE', help='Recording, map image or YAML, or point cloud.'
        ),
    ],
    count: Annotated[int, typer.Option('--count', min=1, help='Most proposals.')] = 10,
    is_searched: Annotated[
        bool, typer.Option('--search', help='Also match on the proposed plans.')
    ] = False,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Propose the floorplans that may contain a robot map or recording.

    With --search the map is matched on the proposed plans, which compete like the storeys of a
    site and with the hypothesis that none is right. Exits with 3 without an answer.

    Example: fpnet library find plans.lib --submap robot_map.yaml

    Example: fpnet library find plans.lib --submap drive/bag --search --json -
    """
    tree = common.load(config, settings, seed)
    from fpnet.api import read_robot_map
    from fpnet.library import PlanLibrary
    from fpnet_core.localizer.maps import MapMatchStatus, segment_robot_map

    known = PlanLibrary.open(library)
    seen = read_robot_map(common.check_input(submap), tree)
    cut = segment_robot_map(seen.submap, tree, seen.is_metric)
    proposals = known.find(cut.segmentation, cut.scale, count)
    for proposal in proposals:
        common.say(f'{proposal.rank:3d}  {proposal.fit:6.0f}  {proposal.path}', json_path)
    report: dict[str, Any] = {
        'plans': len(known),
        'proposals': [{'path': each.path, 'fit': round(each.fit, 1)} for each in proposals],
    }
    best = _searched(proposals, seen, tree) if is_searched else None
    if best is not None:
        common.say(f'{best.status.value} (p {best.probability:.2f}): {best.reason}', json_path)
        report |= {
            'status': best.status.value,
            'probability': round(best.probability, 4),
            'reason': best.reason,
            'path': best.storey or proposals[0].path,
        }
    common.write_json(json_path, report)
    if not proposals or (best is not None and best.status is not MapMatchStatus.MATCHED):
        raise typer.Exit(NO_ANSWER)


def _searched(proposals: tuple[Proposal, ...], seen: RobotMap, tree: FpnetConfig) -> Match | None:
    """Return the match on the most probable proposed plan; None without a proposal."""
    if not proposals:
        return None
    from fpnet.api import match_site
    from fpnet.library.files import proposed_site

    found = match_site(proposed_site(proposals, tree), seen, tree)
    return next(iter(found.values()))
