# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks of topics: missing or without messages, and publishers with incompatible QoS."""

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
    """Yield missing topics of scans and odometry."""
    yield from _missing(seen, seen.scans, seen.topic(seen.scans), SCANS)
    if seen.odometry:
        yield from _missing(seen, seen.odometry, seen.topic(seen.odometry), (ODOMETRY,))


def check_time(seen: Observed) -> Iterator[Finding]:
    """Yield the clock topic if nodes use simulated time that nobody publishes."""
    clock = seen.topic(CLOCK_TOPIC)
    if clock is not None and clock.requests and not clock.offers:
        who = ', '.join(sorted({request.who for request in clock.requests}))
        yield Finding(
            Problem.TOPIC,
            clock.name,
            f'use_sim_time is true for {who}, but nobody publishes /clock: time stands still',
            'set use_sim_time: false on a robot; with a recording or a simulator publish /clock '
            '(ros2 bag play --clock)',
        )


def check_published(seen: Observed, names: Iterable[str]) -> Iterator[Finding]:
    """Yield missing topics among those that a node subscribes to."""
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
    there = f'available: {", ".join(others)}' if others else f'no topic has {what}'
    fix = how.replace('TOPIC', others[0]) if others else f'start the publisher of {what}'
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
            f'{who} publishes it, but no message arrived in {seen.seconds:.0f} s',
            'check that the driver runs and its sensor responds (ros2 topic hz); large clouds '
            'can be lost in transport, see "Large clouds" in docs/ros.md',
        )


def check_qos(seen: Observed) -> Iterator[Finding]:
    """Yield publishers whose QoS existing subscribers, or those of this package, cannot match."""
    for topic in seen.topics:
        for evidence in dict.fromkeys(_mismatches(topic)):
            yield Finding(
                Problem.QOS,
                topic.name,
                evidence,
                'correct the publisher (of a bag: ros2 bag play --qos-profile-overrides-path), or '
                'let the subscriber request less: parameter qos_overrides.'
                f'{topic.name}.subscription.reliability or .durability',
            )


def _mismatches(topic: Topic) -> Iterator[str]:
    for request in topic.requests or _usual_requests(topic):
        for offer in topic.offers:
            if why := mismatch(offer, request):
                by = f' by {offer.who}' if offer.who else ''
                to = request.who or 'its subscriber'
                yield f'published {why[0]}{by}, but {to} requests {why[1]}: no message arrives'


def mismatch(offer: Offer, request: Offer) -> tuple[str, str] | None:
    """Return the offered and the requested policy if they are incompatible, else None."""
    if request.is_reliable and not offer.is_reliable:
        return 'best effort', 'reliable'
    if request.is_latched and not offer.is_latched:
        return 'volatile', 'transient local'
    return None


def _usual_requests(topic: Topic) -> list[Offer]:
    """Return the QoS that this package's nodes request; any for scans and odometry."""
    is_map = topic.msgtype == GRID and topic.name.rpartition('/')[2] in _MAPS
    if topic.name.endswith(TF_STATIC_TOPIC) or is_map:
        return [_LATCHED]
    return [_RELIABLE] if topic.name.endswith(TF_TOPIC) else []
