# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet site``: check the storeys of a site and find those that look alike."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress

app = typer.Typer(help='Check the storeys of a site.', no_args_is_help=True)


@app.callback()
def _group() -> None:
    """
    Check the storeys of a site.

    Example: fpnet site check site.yaml
    """


@app.command('check')
def check(
    site: Annotated[
        Path,
        typer.Argument(
            metavar='SITE',
            help='site.yaml, a folder of maps, or an Open-RMF *.building.yaml.',
        ),
    ],
    config: common.ConfigOption = None,
    settings: common.SetOption = None,
    seed: common.SeedOption = None,
    json_path: common.JsonOption = None,
) -> None:
    """
    List storeys, lifts and stairs of a site, and find storeys that look alike.

    Each storey is matched as a robot map against all others. Where walls alone cannot distinguish
    two storeys, the localizer needs a hint about the storey.

    Example: fpnet site check site.yaml

    Example: fpnet site check maps/ --json -
    """
    tree = common.load(config, settings, seed)
    from fpnet.site_check import check_site
    from fpnet_core.localizer import create_global_localizer
    from fpnet_core.sites.site_files import read_site

    read = read_site(site, tree)
    for storey in read.storeys:
        common.say_reading(storey.plan, json_path)
    with progress('comparing', total=len(read.storeys)) as advance:
        found = check_site(read, create_global_localizer(tree), tree, advance)
    for line in found.lines():
        common.say(line, json_path)
    common.write_json(json_path, found.as_json())
