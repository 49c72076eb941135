# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Input of a run report, and the errors derived from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet.accuracy import pose_errors
from fpnet_core.differences import Differences
from fpnet_core.geometry import Affine2D, Placements
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import Cause, LocalizerOutput, Segmentation

_STEP_M = 0.2  # chosen: shorter steps give no reliable direction
_FIRST_DATE_NS = 946_684_800 * NS_PER_S  # chosen: the year 2000; earlier stamps are no Unix time

PLACEMENT_SYMBOLS = ('circle', 'x-thin-open', 'triangle-up-open')
"""Plotly symbols of the placements' walls, below as characters: colours are not enough."""

PLACEMENT_SIGNS = ('●', '✕', '△')


@dataclass(frozen=True, eq=False)
class RunRecord:
    """
    A run on one floorplan.

    ``outputs`` are all updates in time order, ``published`` all published poses, plan frame,
    nominal metres. ``truth`` holds true poses in a frame of true metres, None if unknown, and
    ``A_plan_truth`` maps that frame to the plan's nominal metres. ``figures`` are metrics by
    name, shown in their order; ``causes`` are the likely causes of a failure, most likely first.
    ``odometry`` is the sensor's path with headings in ``odom``; ``differences`` are those of
    plan and submap, None if unknown. ``building`` is the floorplan's name, empty if unknown, and
    ``room_names`` are the names that the drawing states, by room.
    """

    title: str
    summary: str
    plan: Segmentation
    outputs: tuple[LocalizerOutput, ...] = ()
    published: PlanarTrajectory = field(default_factory=PlanarTrajectory.empty)
    truth: PlanarTrajectory | None = None
    A_plan_truth: Affine2D = field(default_factory=Affine2D.identity)
    figures: Mapping[str, Any] = field(default_factory=dict)
    causes: tuple[Cause, ...] = ()
    odometry: PlanarTrajectory = field(default_factory=PlanarTrajectory.empty)
    differences: Differences | None = None
    building: str = ''
    room_names: Mapping[int, str] = field(default_factory=dict)

    @property
    def heading_line(self) -> str:
        """The building and, if stamps are in Unix time, the date; without a building the title."""
        if not self.building:
            return self.title
        if self.start_ns < _FIRST_DATE_NS:
            return self.building
        date = datetime.fromtimestamp(self.start_ns // NS_PER_S, UTC)
        return f'{self.building}, {date:%Y-%m-%d}'

    @property
    def start_ns(self) -> int:
        """Time origin of the report: the first stamp of the run, 0 without one."""
        stamps = [trajectory.stamps_ns[:1] for trajectory in (self.published, self.truth_on_plan)]
        stamps.append(np.array([output.stamp_ns for output in self.outputs[:1]]))
        known = np.concatenate(stamps)
        return int(known.min()) if len(known) else 0

    @property
    def truth_on_plan(self) -> PlanarTrajectory:
        """True poses in the plan frame; empty without ground truth."""
        if self.truth is None:
            return PlanarTrajectory.empty()
        return self.truth.mapped(self.A_plan_truth)

    def seconds(self, stamps_ns: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the seconds of stamps ``(S,)`` since the start."""
        return (np.asarray(stamps_ns, dtype=np.int64) - self.start_ns) / NS_PER_S

    def heading(self, output: LocalizerOutput) -> float | None:
        """
        Return the robot's heading in the frame ``submap`` [rad]; None if unknown.

        Without odometry, it is the last direction of motion.
        """
        submap = output.submap
        if submap is None:
            return None
        if len(self.odometry) > 1:
            nearest, known = self.odometry.at(np.array([submap.stamp_ns]))
            if known[0]:
                return float(nearest.yaw[0]) - submap.T_odom_submap.yaw
        return _last_direction(submap.path_xy)


def on_one_storey(outputs: Sequence[LocalizerOutput]) -> tuple[LocalizerOutput, ...]:
    """
    Return the updates of a run for display on its final floorplan.

    Updates on another storey lose placements and matches, which refer to another drawing, and
    keep everything else.
    """
    return tuple(
        output
        if output.storey == outputs[-1].storey
        else replace(output, estimates=Placements.empty(), match=None)
        for output in outputs
    )


@dataclass(frozen=True, eq=False)
class TimedErrors:
    """Errors: ``time_s (K,)`` since the start, true ``position_m (K,)``, ``yaw_deg (K,)``."""

    time_s: NDArray[np.float64]
    position_m: NDArray[np.float64]
    yaw_deg: NDArray[np.float64]


def _last_direction(path_xy: NDArray[np.float64]) -> float | None:
    """Return the direction [rad] of the last steps of a path, None if it is too short."""
    if not len(path_xy):
        return None
    back = path_xy[-1] - path_xy
    far = np.flatnonzero(np.linalg.norm(back, axis=1) > _STEP_M)
    return float(np.arctan2(*back[far[-1], ::-1])) if len(far) else None


def published_errors(record: RunRecord) -> TimedErrors:
    """Return the errors of the published poses with ground truth near in time."""
    if record.truth is None or len(record.truth) < 2 or not len(record.published):
        return TimedErrors(np.zeros(0), np.zeros(0), np.zeros(0))
    metric = record.published.mapped(record.A_plan_truth.inv())
    position, yaw = pose_errors(metric, record.truth)
    _, known = record.truth.at(metric.stamps_ns)
    return TimedErrors(record.seconds(metric.stamps_ns[known]), position, np.rad2deg(yaw))


def path_quality(record: RunRecord) -> tuple[str, NDArray[np.float64]]:
    """
    Return the name and the values ``(S,)`` [m] by which the published path is coloured.

    With ground truth these are the position errors, else the standard deviations of the position
    at the last update before each pose; NaN where unknown.
    """
    stamps_ns = record.published.stamps_ns
    values = np.full(len(stamps_ns), np.nan)
    if record.truth is not None and len(record.truth) > 1:
        metric = record.published.mapped(record.A_plan_truth.inv())
        nearest, known = record.truth.at(stamps_ns)
        gaps = np.linalg.norm(metric.xy - nearest.xy, axis=1)
        return 'error', np.where(known, gaps, np.nan)
    known_at = [(o.stamp_ns, o.covariance.cov) for o in record.outputs if o.covariance is not None]
    if known_at:
        sigma = np.array([position_sigma(cov) for _, cov in known_at])
        at = np.searchsorted([stamp for stamp, _ in known_at], stamps_ns, side='right') - 1
        values = np.where(at < 0, sigma[0], sigma[at])
    return 'standard deviation', values


def position_sigma(cov: NDArray[np.float64]) -> float:
    """Return the standard deviation [m] of the position, of a covariance ``(3, 3)``."""
    return float(np.sqrt(cov[0, 0] + cov[1, 1]))


def best_placement_error(record: RunRecord, output: LocalizerOutput) -> float | None:
    """
    Return the error [m] of the robot's position at an update's best placement, accepted or not.

    None without a placement, or without ground truth near in time.
    """
    submap, truth = output.submap, record.truth
    if truth is None or len(truth) < 2 or submap is None or not output.estimates:
        return None
    if not len(submap.path_xy):
        return None
    nearest, known = truth.at(np.array([submap.stamp_ns]))
    if not known[0]:
        return None
    placed = output.estimates[0].A_plan_submap.apply(submap.path_xy[-1])
    return float(np.linalg.norm(record.A_plan_truth.inv().apply(placed) - nearest.xy[0]))
