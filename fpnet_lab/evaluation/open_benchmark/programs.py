# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Programs of the open benchmark: this localizer, its baselines, any command, any Python function.

A program gets a plan and scans, and returns sensor poses on the plan, see :mod:`.protocol`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
import os
from pathlib import Path
import re
import shlex
import signal
import subprocess
import tempfile

import numpy as np
from numpy.typing import NDArray

from fpnet.api import read_robot_map
from fpnet.recordings.opening import open_scans
from fpnet.recordings.truth import read_planar
from fpnet_core.config import FpnetConfig
from fpnet_core.drawings.read import read_plan
from fpnet_core.drawings.scaling import with_scale_of
from fpnet_core.drawings.types import Reading, ReadOptions
from fpnet_core.errors import ConfigError, FpnetError
from fpnet_core.geometry import Affine2D
from fpnet_core.io.maps import YAML_SUFFIXES, read_map
from fpnet_core.localizer import MapMatch, MapMatchStatus
from fpnet_core.localizer.maps import match_maps
from fpnet_core.matching.learned import LearnedMatcher
from fpnet_core.raster.pixels import map_points, pixel_to_xy
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_lab.evaluation.drawings import plan_from_file
from fpnet_lab.evaluation.localization.drives import ProductRun, Registrar, run_product
from fpnet_lab.evaluation.localization.figures import PRODUCT
from fpnet_lab.evaluation.localization.records import MethodRun
from fpnet_lab.evaluation.localization.rivals import BASELINES
from fpnet_lab.evaluation.open_benchmark.protocol import (
    MAP_NAME,
    ODOMETRY_NAME,
    StatedPoses,
    read_answer,
)
from fpnet_lab.evaluation.raster_methods import RASTER_METHODS

Program = Callable[[Path, Path], StatedPoses]
"""Places the scans in a folder on a plan; both are paths."""

_NAMED = re.compile(r'([\w.-]+)=')
_SHOWN_CHARACTERS = 200  # numerical: of a failed program's last line
_STEP_M = 0.1  # numerical: distance over which a heading is mapped


def program_named(said: str, known: Mapping[str, Program], timeout_s: float) -> dict[str, Program]:
    """
    Return the programs that a user names: one, or all ``known`` ones.

    A command is ``NAME=COMMAND``, or ``COMMAND`` of several words, named after its file.

    Raises
    ------
    ConfigError
        If a single word is not known, or a command cannot be split into words.
    """
    if said == 'all' or said in known:
        return {name: known[name] for name in known if said in ('all', name)}
    named = _NAMED.match(said)
    command = said[named.end() :] if named else said
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise ConfigError(f'cannot read the command {command!r}: {error}') from None
    files = [word for word in words if not word.startswith(('{', '-'))]
    if not files or (named is None and len(words) < 2):
        raise ConfigError(f'unknown program {said!r}; choose one of {", ".join(known)}')
    return {named[1] if named else Path(files[-1]).stem: CommandProgram(command, timeout_s)}


@dataclass(frozen=True)
class CommandProgram:
    """
    Any program that runs as a process: ``{plan}``, ``{scans}`` and ``{out}`` are its arguments.

    They are appended to a command that names none of them.
    """

    command: str
    timeout_s: float

    def __call__(self, plan: Path, scans: Path) -> StatedPoses:
        """Run the program and return its answer; raise FpnetError if it fails."""
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / 'answer.tum'
            given = {'plan': str(plan), 'scans': str(scans), 'out': str(out)}
            words = shlex.split(self.command)
            if not any(f'{{{name}}}' in word for name in given for word in words):
                words += [f'{{{name}}}' for name in given]
            for name, path in given.items():
                words = [word.replace(f'{{{name}}}', path) for word in words]
            self._run(words)
            if not out.exists():
                raise FpnetError('it wrote no answer; an empty file says that it cannot say')
            return read_answer(out, read_planar(scans / ODOMETRY_NAME))

    def _run(self, words: list[str]) -> None:
        try:
            # A session of its own, so that what a script has started ends with it.
            started = subprocess.Popen(  # noqa: S603 - the user's own command
                words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
            )
        except OSError as error:
            raise FpnetError(f'cannot run {words[0]}: {error.strerror}') from None
        with started:
            try:
                said = started.communicate(timeout=self.timeout_s)[1].decode(errors='replace')
            except subprocess.TimeoutExpired:
                os.killpg(started.pid, signal.SIGKILL)
                raise FpnetError(f'it took more than {self.timeout_s:g} s') from None
        if started.returncode:
            last = (said.strip().splitlines() or ['no message'])[-1]
            raise FpnetError(f'it ended with {started.returncode}: {last[:_SHOWN_CHARACTERS]}')


def own_programs(config: FpnetConfig) -> Mapping[str, Program]:
    """Return this localizer and the baselines by name."""
    prepared = lru_cache(maxsize=1)(partial(_prepared, config))
    return {name: partial(_own, name, prepared, config) for name in (PRODUCT, *BASELINES)}


@dataclass(frozen=True, eq=False)
class _Prepared:
    """A parsed plan with the run of the localizer, or its match of a finished map."""

    reading: Reading
    frame: PlanarFrame
    registrar: Registrar
    product: ProductRun | None = None
    match: MapMatch | None = None


@dataclass(frozen=True, eq=False)
class PlanarFrame:
    """Map from a parse's frame to that of the case's plan; None: both are the same."""

    H_plan_parse: NDArray[np.float64] | None

    def stated(self, poses: PlanarTrajectory) -> PlanarTrajectory:
        """Return poses of the parse's frame in the plan's frame."""
        if self.H_plan_parse is None:
            return poses
        ahead = poses.xy + _STEP_M * np.column_stack([np.cos(poses.yaw), np.sin(poses.yaw)])
        xy, tip = (map_points(self.H_plan_parse, each) for each in (poses.xy, ahead))
        yaw = np.arctan2(tip[:, 1] - xy[:, 1], tip[:, 0] - xy[:, 0])
        return PlanarTrajectory(poses.stamps_ns, xy, yaw)


def _parsed(plan: Path, config: FpnetConfig) -> tuple[Reading, PlanarFrame]:
    """Parse a plan; a picture is parsed as a drawing at the scale of the YAML beside it."""
    if plan.suffix.lower() in YAML_SUFFIXES:
        return read_plan(plan, config=config), PlanarFrame(None)
    stated = read_map(plan.with_suffix('.yaml'))
    reading = read_plan(plan, ReadOptions(stated.resolution), config)
    H_plan_parse = pixel_to_xy(stated).matrix @ np.linalg.inv(plan_from_file(reading))
    return reading, PlanarFrame(H_plan_parse)


def _prepared(config: FpnetConfig, plan: Path, scans: Path) -> _Prepared:
    reading, frame = _parsed(plan, config)
    config = with_scale_of(reading, config)
    registrar = Registrar(config.odometry)
    robot_map = scans / MAP_NAME
    if robot_map.exists():
        submap = read_robot_map(robot_map, config).submap
        matcher = LearnedMatcher(config.matcher)
        match = match_maps(reading, submap, matcher, config, sub_is_metric=True)
        return _Prepared(reading, frame, registrar, match=match)
    product = run_product(
        registrar.follow(open_scans(scans)), reading.grid, config,
        config.localizer.update_period_s, reading.estimate,
    )  # fmt: skip
    return _Prepared(reading, frame, registrar, product)


def _own(
    name: str,
    prepare: Callable[[Path, Path], _Prepared],
    config: FpnetConfig,
    plan: Path,
    scans: Path,
) -> StatedPoses:
    """Run this localizer or a baseline."""
    prepared = prepare(plan, scans)
    if prepared.match is not None:
        answer = _placed(name, prepared.match, read_planar(scans / ODOMETRY_NAME))
    elif name == PRODUCT:
        assert prepared.product is not None, 'scans make a run'
        answer = answer_of(prepared.product.run)
    else:
        assert prepared.product is not None, 'scans make a run'
        config = with_scale_of(prepared.reading, config)
        answer = answer_of(BASELINES[name](prepared.product, prepared.registrar, config))
    poses = prepared.frame.stated(answer.poses)
    return StatedPoses(poses, answer.is_claimed, answer.probability)


def _placed(name: str, match: MapMatch, poses: PlanarTrajectory) -> StatedPoses:
    """Return the poses in a finished map under its placement; nothing by methods of runs."""
    A_plan_map: Affine2D | None = None
    probability, is_claimed = match.probability, match.status is MapMatchStatus.MATCHED
    if name == PRODUCT:
        A_plan_map = match.A_best
    elif name in RASTER_METHODS:
        found = RASTER_METHODS[name](match)
        if found is not None:
            A_plan_map, is_claimed = found.A_plan_submap, found.is_accepted
            probability = float(np.clip(found.score, 0.0, 1.0))
    if A_plan_map is None:
        return StatedPoses.nothing()
    count = len(poses)
    return StatedPoses(
        poses.mapped(A_plan_map), np.full(count, is_claimed), np.full(count, probability)
    )


def answer_of(run: MethodRun) -> StatedPoses:
    """
    Return a run's published poses as claims and its best placements elsewhere as guesses.

    A placement holds from its update until the next one; odometry moves the pose between them.
    """
    odometry = run.odometry
    updates = np.array([belief.stamp_ns for belief in run.beliefs], dtype=np.int64)
    latest = np.searchsorted(updates, odometry.stamps_ns, side='right') - 1
    published = {int(ns): index for index, ns in enumerate(run.published.stamps_ns)}
    kept = PlanarTrajectory.empty()
    claims: list[bool] = []
    said: list[float] = []
    for index, stamp_ns in enumerate(odometry.stamps_ns.tolist()):
        belief = run.beliefs[latest[index]] if latest[index] >= 0 else None
        if stamp_ns in published:
            pose = run.published.take(np.array([published[stamp_ns]]))
        elif belief is not None and belief.A_plan_odom is not None:
            pose = odometry.take(np.array([index])).mapped(belief.A_plan_odom)
        else:
            continue
        kept = kept.joined(pose)
        claims.append(stamp_ns in published)
        said.append(belief.probability if belief is not None else 0.0)
    return StatedPoses(kept, np.array(claims, dtype=np.bool_), np.array(said, dtype=np.float64))
