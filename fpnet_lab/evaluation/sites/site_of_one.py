# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Overhead of a site with one storey: paired runs on the floorplan and on the site."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.io.maps import write_map
from fpnet_core.localizer import Localizer, create_localizer, replay
from fpnet_core.sites import Site
from fpnet_core.sites.site_files import read_site
from fpnet_core.sites.site_localizer import create_site_localizer
from fpnet_core.sites.storey_plans import storey_plans
from fpnet_lab.evaluation.localization.drives import kept_scans
from fpnet_lab.evaluation.localization.inputs import drive_through
from fpnet_lab.evaluation.localization.runs import UPDATE_PERIOD_S

_ROUNDS = 2
"""Numerical: runs of each; the shortest duration of an update counts, as machines are busy."""

_SENSOR = 'planar'
_FAMILY = 'double_corridor'


@dataclass(frozen=True, eq=False)
class SiteOfOne:
    """
    Run on a floorplan and on a site that consists of it.

    ``is_same``: whether all poses are bitwise equal. ``tick_ms (T, 2)`` and ``scan_ms (S, 2)`` are
    durations of updates and of adding scans, on the plan and on the site.
    """

    is_same: bool
    tick_ms: NDArray[np.float64]
    scan_ms: NDArray[np.float64]


def site_of_one(seed: int, config: FpnetConfig) -> SiteOfOne:
    """Localize a generated recording, alternating between its plan and a one-storey site."""
    recording = drive_through(_FAMILY, _SENSOR, seed)
    scans = kept_scans(recording, config.odometry)
    with TemporaryDirectory() as folder:
        path = Path(folder) / 'plan.yaml'
        write_map(recording.floorplan, path)
        site = read_site(path, config)
    runs = [
        [replay(scans, make(site, config), UPDATE_PERIOD_S) for make in (_on_plan, _on_site)]
        for _ in range(_ROUNDS)
    ]
    plain, sited = runs[0]
    return SiteOfOne(
        np.array_equal(plain.published.xy, sited.published.xy),
        np.min([np.stack([a.tick_ms, b.tick_ms], axis=1) for a, b in runs], axis=0),
        np.min([np.stack([a.add_scan_ms, b.add_scan_ms], axis=1) for a, b in runs], axis=0),
    )


def _on_plan(site: Site, config: FpnetConfig) -> Localizer:
    localizer = create_localizer(config)
    localizer.set_storeys(storey_plans(site, config))
    return localizer


def _on_site(site: Site, config: FpnetConfig) -> Localizer:
    localizer = create_site_localizer(config)
    localizer.set_site(site)
    return localizer


def one_report(runs: Sequence[SiteOfOne]) -> dict[str, Any]:
    """Return the part of the ``fpnet bench sites`` report on one-storey sites."""
    row: dict[str, Any] = {'drives': len(runs), 'same': sum(run.is_same for run in runs)}
    for name in ('tick_ms', 'scan_ms'):
        pairs = np.concatenate([getattr(run, name) for run in runs])
        ratio = pairs[:, 1] / pairs[:, 0]
        row[name] = float(np.median(pairs[:, 0]))
        row[f'{name}_site'] = float(np.median(pairs[:, 1]))
        row[f'{name}_ratio'] = float(np.median(ratio))
        row[f'{name}_ratio_spread'] = float(np.subtract(*np.percentile(ratio, [75, 25])))
    return row
