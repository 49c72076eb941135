# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A localization run of a recording on a floorplan."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import cached_property
import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fpnet.accuracy import RunSummary, summarize_run
from fpnet.recordings.opening import open_scans
from fpnet.recordings.posed_scans import PosedScans
from fpnet.recordings.trajectories import read_poses
from fpnet.rooms import NamedRooms
from fpnet.viz.pictures import figure_of, html_of
from fpnet_core.config import FpnetConfig, OdometryChoice, ScanStamp
from fpnet_core.differences import Differences
from fpnet_core.differences.of_output import differences_of
from fpnet_core.differences.outdated import Outdated, outdated_here
from fpnet_core.doctor.sensor import MountVotes
from fpnet_core.drawings.scaling import with_scale_of
from fpnet_core.drawings.types import Reading
from fpnet_core.errors import BagFormatError, OdometryError
from fpnet_core.geometry import SE2, Affine2D
from fpnet_core.io.scans import Scan, ScanSource
from fpnet_core.io.topic_names import TF_TOPIC
from fpnet_core.localizer import Replay, ReplayResult
from fpnet_core.localizer.diagnosis import explain_run
from fpnet_core.localizer.guidance import NextLook, next_look
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.odometry import GuidedOdometry
from fpnet_core.scoring.findings import Sensed
from fpnet_core.scoring.invocation import Invocation
from fpnet_core.sites import Site, Storey
from fpnet_core.sites.site_localizer import SiteLocalizer
from fpnet_core.stamps import NS_PER_S
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import Cause, LocalizerOutput, Segmentation, Status

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MAP_BYTES = 128e6  # chosen: memory of the maps kept in outputs; the localizer holds as much


def scans_of(
    recording: str | Path,
    *,
    poses: str | Path | None = None,
    odometry: OdometryChoice | None = None,
    topics: Sequence[str] = (),
    scan_stamp: ScanStamp = 'auto',
) -> ScanSource:
    """
    Open the scans of a recording with the chosen odometry.

    Raises
    ------
    OdometryError
        If the recording's own odometry was chosen and it has none.
    """
    # With sensor poses, the transform from sensor to robot is not needed.
    unread = '' if odometry == 'kiss' or poses is not None else None
    path = Path(recording)
    source = open_scans(path, topics=topics, odometry_topic=unread, scan_stamp=scan_stamp)
    if poses is not None:
        return PosedScans(source, read_poses(Path(poses)))
    if odometry in ('robot', 'both') and not source.has_poses:
        source = _with_poses_of_tf(path, topics, scan_stamp)
    return source


def _with_poses_of_tf(path: Path, topics: Sequence[str], scan_stamp: ScanStamp) -> ScanSource:
    with suppress(BagFormatError):
        source = open_scans(path, topics=topics, odometry_topic=TF_TOPIC, scan_stamp=scan_stamp)
        if source.has_poses:
            return source
    raise OdometryError(
        f'{path} has no odometry; record nav_msgs/Odometry, or /tf and /tf_static, as well, '
        'or use KISS-ICP'
    )


class Run:
    """
    A localization run of a recording on a floorplan or site.

    Iterating yields the output of each update while the recording is read; all else first reads
    on to its end. Poses are in the plan frame; on a site, those on the final storey.

    Parameters
    ----------
    plan : parsed floorplan, or a site
    scans : scans of the recording, see :func:`scans_of`
    config : configuration of the localizer
    advance : called after each scan
    odometry : both: KISS-ICP registers scans with poses too, initialized and checked by them
    """

    def __init__(
        self,
        plan: Reading | Site,
        scans: ScanSource,
        config: FpnetConfig,
        advance: Callable[[], None] = lambda: None,
        odometry: OdometryChoice | None = None,
    ) -> None:
        site = Site('', (Storey('', plan),)) if isinstance(plan, Reading) else plan
        self.site, self.config, self._scans = site, config, scans
        self._matcher = LearnedMatcher(config.matcher)
        self._localizer = SiteLocalizer(config, self._matcher)
        self._localizer.set_site(site)
        self._mount = MountVotes()
        self._replay = Replay(
            self._watched(scans),
            self._localizer,
            config.localizer.update_period_s,
            GuidedOdometry(config.odometry).register_scan,
            advance,
            registers_all=odometry == 'both',
            map_bytes=_MAP_BYTES,
        )

    def __iter__(self) -> Iterator[LocalizerOutput]:
        """Yield the outputs of the remaining updates."""
        return iter(self._replay)

    @cached_property
    def result(self) -> ReplayResult:
        """All updates, all published poses and the odometry."""
        for _ in self._replay:
            pass
        return self._replay.result()

    @property
    def so_far(self) -> ReplayResult:
        """The run up to the newest update; does not read on."""
        return self._replay.result()

    @property
    def rooms(self) -> Segmentation:
        """Rooms and doors of the newest update's floorplan, at its current scale."""
        said = self._localizer.snapshot.plan
        plan = self._localizer.plan if said is None else said.nominal
        assert plan is not None  # set in __init__
        return plan.segmentation

    @cached_property
    def named_rooms(self) -> NamedRooms:
        """The floorplan's rooms that have a name."""
        return NamedRooms.of(self.plan)

    @property
    def room(self) -> str:
        """Name of the room of the final pose; empty unless localized in a named room."""
        if self.status is not Status.LOCALIZED:
            return ''
        return self.named_rooms.at(self.poses.xy[-1:])[0]

    @property
    def plan(self) -> Reading:
        """The floorplan; on a site, that of the final storey."""
        if len(self.site.storeys) == 1:
            return self.site.storeys[0].plan
        return self.site.storey(self.storey).plan

    @property
    def storey(self) -> str:
        """The final storey; empty for a single floorplan."""
        return self.last.storey or self.site.storeys[0].name

    @property
    def last(self) -> LocalizerOutput:
        """The output of the last update."""
        return self.result.outputs[-1] if self.result.outputs else self._localizer.output

    @property
    def status(self) -> Status:
        """The final status."""
        return self.last.status

    @property
    def poses(self) -> PlanarTrajectory:
        """Published poses in the plan frame: stamps, positions [m] and yaw [rad]."""
        return self.result.published.take(self._is_here)

    @property
    def covariances(self) -> NDArray[np.float64]:
        """Covariances ``(S, 3, 3)`` of the published poses: x, y [m] and yaw [rad]."""
        return self.result.covariances[self._is_here]

    @property
    def _is_here(self) -> NDArray[np.bool_]:
        """Mask ``(S,)`` of the published poses on the final storey."""
        return np.array([name == self.storey for name in self.result.storeys], dtype=np.bool_)

    @property
    def segmentation(self) -> Segmentation:
        """Rooms and doors of the floorplan, at the final scale."""
        self.result  # noqa: B018 - reads to the end, for the final scale
        return self.rooms

    @cached_property
    def differences(self) -> Differences | None:
        """Differences between plan and final submap; None unless localized at the end."""
        last, plan = self.last, self._localizer.snapshot.plan
        return None if plan is None else differences_of(last, plan)

    @property
    def outdated(self) -> Outdated | None:
        """How outdated the plan is around the final pose; None if it is not."""
        return None if self.differences is None else outdated_here(self.last, self.differences)

    @cached_property
    def next_look(self) -> NextLook | None:
        """
        Where to look next; None if localized, or if no viewpoint is informative.

        Its directions are relative to the sensor's heading.
        """
        plan, path = self._localizer.snapshot.plan, self.result.odometry
        if plan is None or not len(path):
            return None
        (x, y), yaw = path.xy[-1].tolist(), float(path.yaw[-1])
        at = SE2.from_xy_yaw(x, y, yaw).as_matrix4()
        return next_look(plan.nominal.evidence, self.last, at)

    def causes(
        self, invocation: Invocation | None = None, storey: int | None = None
    ) -> tuple[Cause, ...]:
        """
        Return the likely causes of a failure, most likely first; none if localized.

        ``invocation`` is the command line, from which the next commands are made; ``storey`` is
        the requested storey of the sheet.
        """
        if self.status is Status.LOCALIZED:
            return ()
        plan, outputs = self.plan, self.result.outputs
        config = with_scale_of(plan, self.config)
        sensed = Sensed(self._mount.is_upside_down, self._matched_hz)
        return explain_run(
            outputs, plan.grid, self._matcher, config, plan, invocation, storey, sensed
        )

    def _watched(self, scans: ScanSource) -> Iterator[Scan]:
        for scan in scans:
            self._mount.look(scan)
            yield scan

    @property
    def _matched_hz(self) -> float:
        """Rate [Hz] of the scans that KISS-ICP registers; infinite if scans have poses."""
        stamps_ns = self.result.odometry.stamps_ns
        if self._scans.has_poses or len(stamps_ns) < 2:
            return math.inf
        return NS_PER_S / max(1.0, float(np.median(np.diff(stamps_ns))))

    def summary(
        self, truth: PlanarTrajectory | None = None, A_plan_truth: Affine2D | None = None
    ) -> RunSummary:
        """Return the run's metrics; errors need the true poses."""
        run = self.result
        A = Affine2D.identity() if A_plan_truth is None else A_plan_truth
        return summarize_run(self.poses, run.odometry, run.tick_ms, truth, A, self.covariances)

    def __repr__(self) -> str:
        """Return a one-line summary, once the run was read to its end."""
        on = self.site.name or self.site.storeys[0].plan.drawing.name
        if 'result' not in self.__dict__:
            return f'<Run on {on}, not finished yet>'
        return f'<Run on {on}: {self.last.said}; {self.summary()}>'

    def plot(self, figure: Figure | None = None) -> Figure:
        """Draw the plan with the published poses, and the final submap."""
        from fpnet.viz.run import draw_run

        figure = figure_of(figure, (16.0, 8.5))
        draw_run(figure, self.segmentation, self.last, self.poses)
        return figure

    def _repr_html_(self) -> str:
        return html_of(self, self.plot if 'result' in self.__dict__ else None)
