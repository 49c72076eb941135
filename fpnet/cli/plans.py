# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What commands share that take a floorplan or a site, and say where drawings are out of date."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from fpnet.cli import common
from fpnet_core.errors import ConfigError

if TYPE_CHECKING:
    from fpnet_core.config import FpnetConfig
    from fpnet_core.differences import Differences
    from fpnet_core.drawings.types import Reading
    from fpnet_core.sites import Site


def read_plans(
    floorplan: Path | None,
    site: Path | None,
    said: common.DrawingOptions,
    tree: FpnetConfig,
    json_path: Path | None,
) -> Reading | Site:
    """Return the floorplan or the site that was named; ConfigError unless it is one of them."""
    if (floorplan is None) == (site is None):
        raise ConfigError('give --floorplan or --site, one of them')
    if floorplan is not None:
        reading = said.read(floorplan, tree)
        common.say_reading(reading, json_path)
        return reading
    assert site is not None  # one of them was named
    said.refuse('is for one drawing; say it of a storey in the site')
    from fpnet_core.sites.site_files import read_site

    read = read_site(site, tree)
    for storey in read.storeys:
        common.say_reading(storey.plan, json_path)
    return read


def write_differences(folder: Path, found: Differences) -> None:
    """Write where a drawing is out of date as GeoJSON and as a picture."""
    from fpnet.geojson import write_geojson
    from fpnet.viz.differences import save_differences

    write_geojson(folder / 'differences.geojson', found)
    save_differences(found, folder / 'differences.png')
