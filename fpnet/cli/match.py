# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet match``: estimate the transform between two maps, and scales that are not stated."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
import typer

from fpnet.cli import common
from fpnet.cli.exits import NO_ANSWER
from fpnet.cli.plans import read_plans

if TYPE_CHECKING:
    from fpnet.api.values import Match, RobotMap
    from fpnet_core.config import FpnetConfig
    from fpnet_core.drawings.types import Reading
    from fpnet_core.geometry import Affine2D
    from fpnet_core.localizer import MapMatch
    from fpnet_core.matching import RegionMatcher
    from fpnet_core.scoring.invocation import Invocation
    from fpnet_core.sites import Site
    from fpnet_core.types import Cause, GridMap


@common.reads_drawing
def command(
    submap: common.SubmapOption,
    said: common.DrawingOptions,
    plan: common.FloorplanOption = None,
    site: common.SiteOption = None,
    submap_storey: common.SubmapStoreyOption = None,
    plot: Annotated[
        Path | None, typer.Option('--plot', metavar='PNG', help='Plot both maps and the match.')
    ] = None,
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    Find the transform between a floorplan, or a storey of a site, and a robot map.

    A map_server YAML or point cloud states its scale, which is trusted within
    pose.scale_tolerance (see localizer.scale_policy). Other scales are estimated.

    The affine (the homography, if a perspective was rectified) maps submap pixels (x right, y
    down, integers at pixel centres) to pixels of the drawing; a cloud's pixels are those of its
    raster, row 0 at the top. The scale in the JSON is in plan metres per submap metre; a robot
    map without a scale has 0.05 m per pixel. Exits with 3 if no match is accepted.

    Example: fpnet match --floorplan plan.png --submap robot_map.png --json match.json

    Example: fpnet match --floorplan plan.yaml --submap robot_map.yaml --plot match.png

    Example: fpnet match --site site.yaml --submap robot_map.yaml --json -
    """
    tree = common.load(config, settings, seed)
    from fpnet.api import read_robot_map

    common.check_input(submap)
    plans = read_plans(plan, site, said, tree, json_path)
    seen = read_robot_map(submap, tree, storey=submap_storey)
    found = matched(plans, seen, tree)
    given = common.typed_settings(config, settings)
    given += [] if submap_storey is None else ['--submap-storey', str(submap_storey)]
    typed = said.typed(('match', '--submap', str(submap), *given), plan, site)
    report = report_match(found, seen, tree, typed, said, json_path)
    common.write_json(json_path, report)
    if plot is not None:
        _draw(found.best, plot)
    if report['status'] != 'matched':
        raise typer.Exit(NO_ANSWER)


def _draw(result: MapMatch, path: Path) -> None:
    from fpnet.viz.match import save_map_match

    save_map_match(result, path)


@dataclass(frozen=True, eq=False)
class Found:
    """Matches per storey, most probable first, and the drawing of the first one."""

    matches: dict[str, Match]
    plan: Reading

    @property
    def best(self) -> Match:
        """The match on the most probable storey."""
        return next(iter(self.matches.values()))

    def storeys(self) -> dict[str, Any]:
        """Return the results about storeys; empty for a single floorplan."""
        if len(self.matches) < 2:
            return {}
        probability = {name: round(each.probability, 4) for name, each in self.matches.items()}
        return {'storey': self.best.storey, 'storeys': probability}


def matched(plans: Reading | Site, seen: RobotMap, tree: FpnetConfig) -> Found:
    """Match a robot map on a drawing, or on each storey of a site."""
    from fpnet.api import match, match_site
    from fpnet_core.drawings.types import Reading

    if isinstance(plans, Reading):
        return Found({'': match(plans, seen, tree)}, plans)
    matches = match_site(plans, seen, tree)
    return Found(matches, plans.storey(next(iter(matches))).plan)


def report_match(
    found: Found,
    seen: RobotMap,
    tree: FpnetConfig,
    typed: Invocation,
    said: common.DrawingOptions,
    json_path: Path | None,
) -> dict[str, Any]:
    """Print the result of a match and the causes of a failed one; return it for ``--json``."""
    from fpnet_core.matching.learned import LearnedMatcher

    result = found.best
    causes = _causes(result, LearnedMatcher(tree.matcher), tree, found.plan, typed, said.storey)
    stated = found.plan.scale.is_known, seen.is_metric
    report = _report(result, found.plan, seen.submap.grid, *stated) | found.storeys()
    report['causes'] = [cause.as_json() for cause in causes]
    common.say(f'{report["status"]} (p {result.probability:.2f}): {result.reason}', json_path)
    common.say_causes(causes, json_path)
    return report


def _causes(
    result: MapMatch,
    matcher: RegionMatcher,
    tree: FpnetConfig,
    reading: Reading,
    invocation: Invocation,
    storey: int | None,
) -> tuple[Cause, ...]:
    """Return the likely causes of a failed match; none if it was accepted."""
    from fpnet_core.localizer import MapMatchStatus
    from fpnet_core.localizer.diagnosis import explain_match

    if result.status is MapMatchStatus.MATCHED:
        return ()
    return explain_match(result, matcher, tree, reading, invocation, storey)


def _report(
    result: MapMatch, plan: Reading, sub: GridMap, plan_is_stated: bool, sub_is_stated: bool
) -> dict[str, Any]:
    from fpnet_core.drawings.plan_files import is_affine

    H = None if result.A_plan_sub is None else _in_pixels(result.A_plan_sub, plan, sub)
    return {
        'status': result.status.value,
        'affine_plan_from_submap_px': H[:2].tolist() if H is not None and is_affine(H) else None,
        'homography_plan_from_submap_px': None if H is None else H.tolist(),
        'score': round(result.score, 4),
        'probability': round(result.probability, 4),
        'scale': None if result.scale is None else round(result.scale, 4),
        'plan_metres_per_pixel': plan.scale.resolution_m,
        'plan_scale_stated': plan_is_stated,
        'submap_scale_stated': sub_is_stated,
        'reason': result.reason,
        'timings_ms': {name: round(ms, 2) for name, ms in result.timings_ms.items()},
    }


def _in_pixels(A_plan_sub: Affine2D, plan: Reading, sub: GridMap) -> NDArray[np.float64]:
    """Return the homography (3, 3) from pixels of the robot map to those of the drawing."""
    from fpnet_core.raster.pixels import pixel_to_xy

    H = np.linalg.inv(plan.H_plan_image) @ A_plan_sub.matrix @ pixel_to_xy(sub).matrix
    return np.asarray(H / H[2, 2])
