# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Observations from the first seconds of a recording, as input of the checks."""

from __future__ import annotations

from pathlib import Path

from fpnet.recordings.opening import bag_within
from fpnet_core.doctor.observed import Observed, Offer
from fpnet_core.doctor.observer import Observer
from fpnet_core.io.bags import BagReader
from fpnet_core.stamps import NS_PER_S


def observe_bag(
    path: Path, seconds: float, scans: str = '', odometry: str | None = ''
) -> Observed:
    """
    Return the observations from the first ``seconds`` of a bag.

    Raises
    ------
    BagFormatError
        If it is missing or damaged.
    """
    with BagReader(bag_within(path)) as bag:
        observer = Observer(bag.topics, scans, odometry)
        first_ns: int | None = None
        last_ns = 0
        for topic, heard_ns, message in bag.messages(observer.topics):
            first_ns = heard_ns if first_ns is None else first_ns
            if heard_ns - first_ns > seconds * NS_PER_S:
                break
            observer.hear(topic, heard_ns, message)
            last_ns = heard_ns
        offers = {
            topic: tuple(Offer('', *each) for each in bag.offers(topic)) for topic in bag.topics
        }
    listened_s = 0.0 if first_ns is None else (last_ns - first_ns) / NS_PER_S
    return observer.observed(listened_s, offers)
