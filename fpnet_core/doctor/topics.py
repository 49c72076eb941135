# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Topics that are missing or silent, and publishers whose QoS no subscriber can take."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from fpnet_core.doctor.findings import Finding, Problem
from fpnet_core.doctor.observed import Observed, Offer, Topic
from fpnet_core.io.message_types import GRID, ODOMETRY, POINT_CLOUD, SCANS
from fpnet_core.io.topic_names import CLOCK_TOPIC, TF_STATIC_TOPIC, TF_TOPIC

_RELIABLE, _LATCHED = Offer(), Offer(is_latched=True)

_MAPS = ('floorplan', 'map')
_MEANT = {
    POINT_CLOUD: ('scans', 'points:=TOPIC, or scan:=TOPIC'),
    ODOMETRY: ('odometry', 'remap kiss/odometry to TOPIC'),
    GRID: ('a floorplan', 'remap floorplan to TOPIC'),
}


def check_topics(seen: Observed) -> Iterator[Finding]:
    """Yield what is missing of scans and odometry."""
    yield from _missing(seen, seen.scans, seen.topic(seen.scans), SCANS)
    if seen.odometry:
        yield from _missing(seen, seen.odometry, seen.topic(seen.odometry), (ODOMETRY,))


def check_time(seen: Observed) -> Iterator[Finding]:
    """Yield that time stands still: nodes follow a simulated clock that nobody publishes."""
    clock = seen.topic(CLOCK_TOPIC)
    if clock is not None and clock.requests and not clock.offers:
        who = ', '.join(sorted({request.who for request in clock.requests}))
        yield Finding(
            Problem.TOPIC,
            clock.name,
            f'use_sim_time is true for {who}, and nobody publishes the time: it stands still',
            'set use_sim_time: false on a robot; with a recording or a simulator publish /clock '
            '(ros2 bag play --clock)',
        )


def check_published(seen: Observed, names: Iterable[str]) -> Iterator[Finding]:
    """Yield what is missing of topics that a node subscribes to, whether they are heard or not."""
    for name in names:
        topic = seen.topic(name)
        if topic is not None and not topic.offers:
            kinds = SCANS if topic.msgtype in SCANS else (topic.msgtype,)
            yield from _missing(seen, name, None, kinds)


def _missing(
    seen: Observed, name: str, topic: Topic | None, msgtypes: tuple[str, ...]
) -> Iterator[Finding]:
    what, how = _MEANT[msgtypes[0]]
    others = [n for n in seen.of_types(*msgtypes) if n != name]
    there = f'there is {", ".join(others)}' if others else f'nothing here carries {what}'
    fix = how.replace('TOPIC', others[0]) if others else f'start what publishes {what}'
    if topic is None or not (len(topic) or topic.offers):
        evidence = f'nobody publishes it; {there}' if name else there
        yield Finding(Problem.TOPIC, name or what, evidence, fix)
    elif topic.msgtype not in msgtypes:
        evidence = f'it is a {topic.msgtype}, not {what}; {there}'
        yield Finding(Problem.TOPIC, name, evidence, fix)
    elif not len(topic) and not any(_mismatches(topic)):
        who = ', '.join(sorted({offer.who for offer in topic.offers if offer.who})) or 'somebody'
        yield Finding(
            Problem.SILENT,
            name,
            f'{who} publishes it, but nothing came in {seen.seconds:.0f} s',
            'look whether the driver runs and its sensor answers (ros2 topic hz); large clouds '
            'can be lost on the way, see "Large clouds" in docs/ros.md',
        )


def check_qos(seen: Observed) -> Iterator[Finding]:
    """Yield publishers that subscribers of this package, or those that are there, cannot hear."""
    for topic in seen.topics:
        for evidence in dict.fromkeys(_mismatches(topic)):
            yield Finding(
                Problem.QOS,
                topic.name,
                evidence,
                'mend the publisher (of a recording: ros2 bag play --qos-profile-overrides-path), '
                'or let the subscriber ask for less: parameter qos_overrides.'
                f'{topic.name}.subscription.reliability or .durability',
            )


def _mismatches(topic: Topic) -> Iterator[str]:
    for request in topic.requests or _usual_requests(topic):
        for offer in topic.offers:
            if why := mismatch(offer, request):
                by = f' by {offer.who}' if offer.who else ''
                to = request.who or 'its subscriber'
                yield f'published {why[0]}{by}, but {to} asks for {why[1]}: nothing arrives'


def mismatch(offer: Offer, request: Offer) -> tuple[str, str] | None:
    """Return what is offered and what is asked for instead; None where both fit."""
    if request.is_reliable and not offer.is_reliable:
        return 'best effort', 'reliable'
    if request.is_latched and not offer.is_latched:
        return 'volatile', 'transient local'
    return None


def _usual_requests(topic: Topic) -> list[Offer]:
    """Return what this package's nodes ask of a topic; scans and odometry may be of any QoS."""
    is_map = topic.msgtype == GRID and topic.name.rpartition('/')[2] in _MAPS
    if topic.name.endswith(TF_STATIC_TOPIC) or is_map:
        return [_LATCHED]
    return [_RELIABLE] if topic.name.endswith(TF_TOPIC) else []
