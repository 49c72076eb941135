# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""``fpnet doctor``: find faults of a recording or a running robot, and their fixes."""

from __future__ import annotations

from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fpnet.cli import common
from fpnet.cli.progress import progress
from fpnet_core.errors import ConfigError

if TYPE_CHECKING:
    from fpnet_core.doctor import Finding, Observed

LISTENERS = 'fpnet.listeners'
"""Entry-point group of functions ``(seconds, scans, odometry) -> Observed`` on live topics."""


def command(
    bag: Annotated[
        Path | None,
        typer.Argument(metavar='[BAG]', help='Recording; default: the running robot.'),
    ] = None,
    topic: Annotated[
        str, typer.Option('--topic', metavar='TOPIC', help='Scan topic; default: most likely one.')
    ] = '',
    odometry: Annotated[
        str,
        typer.Option('--odometry', metavar='TOPIC', help='Odometry topic; default: most likely.'),
    ] = '',
    seconds: Annotated[
        float, typer.Option('--seconds', min=1.0, max=60.0, help='Seconds to examine.')
    ] = 10.0,
    json_path: common.JsonOption = None,
) -> None:
    """
    Find faults of a recording or a running robot, and say how to fix them.

    Checks the first seconds: topics, QoS, frames, clocks, point times, sensor mounting, and
    whether odometry agrees with the scans. Exits with 1 if it finds a fault.

    Example: fpnet doctor drive.bag --json -

    Example: fpnet doctor --topic /lidar/points --odometry /odom
    """
    seen = _observed(bag, seconds, topic, odometry)
    from fpnet.doctor.examine import examine

    found = examine(seen)
    for line in _lines(seen, found):
        common.say(line, json_path)
    if json_path is not None:
        common.write_json(json_path, _as_json(seen, found))
    if found:
        raise typer.Exit(1)


def _observed(bag: Path | None, seconds: float, topic: str, odometry: str) -> Observed:
    if bag is not None:
        from fpnet.doctor.bag import observe_bag

        return observe_bag(common.check_input(bag), seconds, topic, odometry)
    listeners = list(entry_points(group=LISTENERS))
    if not listeners:
        raise ConfigError('live topics need ROS, which is not installed; give a recording')
    with progress('listening'):
        observed: Observed = listeners[0].load()(seconds, topic, odometry)
    return observed


def _lines(seen: Observed, found: list[Finding]) -> list[str]:
    heard = ', '.join(
        f'{len(topic)} on {topic.name}'
        for topic in map(seen.topic, (seen.scans, seen.odometry, seen.imu))
        if topic is not None
    )
    lines = [f'listened for {seen.seconds:.1f} s: {heard or "no scans and no odometry"}']
    for number, finding in enumerate(found, start=1):
        lines.append(f'{number}. {finding.said}\n   next: {finding.next}')
    return lines if found else [*lines, 'nothing is wrong']


def _as_json(seen: Observed, found: list[Finding]) -> dict[str, object]:
    return {
        'seconds': seen.seconds,
        'scans': seen.scans,
        'odometry': seen.odometry,
        'imu': seen.imu,
        'findings': [finding.as_json() for finding in found],
    }
