# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks of the TF tree: unknown frames, frames with two parents, and loops."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from difflib import get_close_matches

from fpnet_core.doctor.findings import Finding, Problem
from fpnet_core.doctor.observed import Observed
from fpnet_core.io.topic_names import TF_STATIC_TOPIC, TF_TOPIC

_STATIC = (
    'ros2 run tf2_ros static_transform_publisher --x X --y Y --z Z --yaw YAW '
    '--frame-id {base} --child-frame-id {frame}'
)


def check_tree(seen: Observed) -> Iterator[Finding]:
    """Yield frames with two parents, and loops."""
    parents: dict[str, set[str]] = defaultdict(set)
    for each in seen.transforms:
        parents[each.child].add(each.parent)
    for child, above in sorted(parents.items()):
        if len(above) > 1:
            names = ' and '.join(sorted(above))
            yield Finding(
                Problem.PARENTS,
                child,
                f'its parents are {names}: they overwrite each other',
                'disable one of the two publishers (publish_odom_tf: false of the odometry node, '
                'publish_tf: false of a driver), or rename one child frame',
            )
    for loop in _loops({child: sorted(above)[0] for child, above in parents.items()}):
        yield Finding(
            Problem.LOOP,
            loop[0],
            f'{" -> ".join([*loop, loop[0]])}: TF cannot look up these frames',
            'stop the publisher of one of these transforms; publish each transform in one '
            'direction only, from parent to child',
        )


def _loops(parent: dict[str, str]) -> Iterator[list[str]]:
    """Yield every loop once, starting at its alphabetically first frame."""
    done: set[str] = set()
    for start in sorted(parent):
        chain: list[str] = []
        here = start
        while here in parent and here not in chain and here not in done:
            chain.append(here)
            here = parent[here]
        if here in chain:
            loop = chain[chain.index(here) :]
            first = loop.index(min(loop))
            yield loop[first:] + loop[:first]
        done.update(chain)


def check_frames(seen: Observed) -> Iterator[Finding]:
    """Yield scans in frames without a transform to the robot's base."""
    topic, base = seen.topic(seen.scans), seen.child_frame
    for frame in () if topic is None else dict.fromkeys(topic.frames):
        if not frame:
            yield Finding(
                Problem.FRAME,
                seen.scans,
                'its header has no frame_id',
                "set frame_id of the lidar's driver",
            )
        elif base and seen.tree.root(frame) != seen.tree.root(base):
            yield Finding(
                Problem.FRAME,
                frame,
                f'scans on {seen.scans} are in it, odometry is of {base}, and no transform on '
                f'{TF_STATIC_TOPIC} connects them{_suggestion(seen, frame)}',
                _STATIC.format(base=base, frame=frame) + f'; or set frame_id of the driver. '
                f'A transform on {TF_TOPIC} is not enough: mounts must be static',
            )
    if seen.odometry and topic is not None and not base and len(topic):
        odometry = seen.topic(seen.odometry)
        if odometry is not None and len(odometry):
            yield Finding(
                Problem.FRAME,
                seen.odometry,
                'its messages have no child_frame_id, so the frame of the poses is unknown',
                'set the base frame of the odometry publisher',
            )


def _suggestion(seen: Observed, frame: str) -> str:
    known = {name for each in seen.transforms for name in (each.parent, each.child)} - {frame}
    near = get_close_matches(frame, sorted(known), n=1)
    return f'; did you mean {near[0]}?' if near else ''
