# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Input of a floorplan or site, and output of differences, shared by several commands."""

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
    """Return the floorplan or the site; raise ConfigError unless exactly one is given."""
    if (floorplan is None) == (site is None):
        raise ConfigError('give either --floorplan or --site')
    if floorplan is not None:
        reading = said.read(floorplan, tree)
        common.say_reading(reading, json_path)
        return reading
    assert site is not None  # exactly one was given
    said.refuse('applies to one drawing; set it for a storey in the site file')
    from fpnet_core.sites.site_files import read_site

    read = read_site(site, tree)
    for storey in read.storeys:
        common.say_reading(storey.plan, json_path)
    return read


def write_differences(folder: Path, found: Differences) -> None:
    """Write ``differences.geojson`` and ``differences.png`` into a folder."""
    from fpnet.geojson import write_geojson
    from fpnet.viz.differences import save_differences

    write_geojson(folder / 'differences.geojson', found)
    save_differences(found, folder / 'differences.png')
