# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Evaluation of a demo: poses published during a simulated recording, against the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fpnet.accuracy import RunSummary, summarize_run
from fpnet.recordings.truth import (
    TRUTH_NAME,
    TRUTH_POSES_NAME,
    read_distortion,
    read_json,
    read_planar,
)
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import Affine2D
from fpnet_core.io.runs import read_output
from fpnet_core.io.sessions import POSES_NAME, SESSION_NAME, TICKS_NAME
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import LocalizerOutput


@dataclass(frozen=True, eq=False)
class DemoRun:
    """
    Evaluated demo.

    ``published`` is in the floorplan's frame and nominal metres, ``truth`` in true metres in
    ``building``; ``A_plan_building`` maps the latter to the former.
    """

    summary: RunSummary
    published: PlanarTrajectory
    truth: PlanarTrajectory
    A_plan_building: Affine2D
    scans: int
    registered_scans: int

    @property
    def is_success(self) -> bool:
        """True if the robot was localized and no wrong pose was published."""
        return self.summary.localized and self.summary.wrong_poses == 0

    def as_json(self) -> dict[str, Any]:
        """Return the figures as JSON-serializable values."""
        return {
            **self.summary.as_json(),
            'scans': self.scans,
            'registered_scans': self.registered_scans,
        }


def rate_demo(recording_dir: Path, session_dir: Path) -> DemoRun:
    """
    Compare the poses published during a session with the recording's truth.

    Raises
    ------
    FpnetError
        If a file is missing or damaged.
    """
    truth = read_planar(recording_dir / TRUTH_POSES_NAME)
    A_plan_building = read_distortion(recording_dir / TRUTH_NAME)
    session = read_json(session_dir / SESSION_NAME, 'run the demo again')
    published = read_planar(session_dir / POSES_NAME)
    try:
        totals = [update['total_ms'] for update in session['ticks'] if 'total_ms' in update]
        tick_ms = np.array(totals, dtype=np.float64)
        scans, registered = int(session['scans']), int(session['registered_scans'])
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise FpnetError(
            f'{session_dir / SESSION_NAME} lacks {error} or holds a bad value; run the demo again'
        ) from None
    summary = summarize_run(published, truth, tick_ms, truth, A_plan_building)
    return DemoRun(summary, published, truth, A_plan_building, scans, registered)


def read_ticks(session_dir: Path) -> tuple[LocalizerOutput, ...]:
    """
    Return all updates of a session that had a submap, by sensor time.

    Updates without a submap are left out: they are stamped by the node's clock.

    Raises
    ------
    FpnetError
        If a file is damaged.
    """
    files = (session_dir / TICKS_NAME).glob('*.npz')
    updates = [
        replace(update, stamp_ns=update.submap.stamp_ns)
        for update in map(read_output, files)
        if update.submap is not None
    ]
    return tuple(sorted(updates, key=lambda update: update.stamp_ns))
