# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of topics with a fixed meaning."""

import re

from fpnet_core.io.message_types import POINT_CLOUD

TF_TOPIC, TF_STATIC_TOPIC, CLOCK_TOPIC = '/tf', '/tf_static', '/clock'
"""Given: by tf2, and for simulated time."""

KISS_FRAME, KISS_ODOMETRY = 'kiss/frame', 'kiss/odometry'
"""Given: topics of KISS-ICP's own node, in its namespace."""

TRUTH_TOPICS = re.compile(r'truth|(^|[/_])gt([/_]|$)', re.IGNORECASE)
"""Topics with ground truth, which must not be used as odometry."""

_REGISTERED = re.compile(r'(^|/)kiss/(frame|keypoints|local_map)$')


def is_registered(topic: str) -> bool:
    """
    Return whether KISS-ICP publishes the clouds on a topic.

    Such clouds are deskewed, have no point times, and are stamped like their poses.
    """
    return _REGISTERED.search(topic) is not None


def usable_clouds(topics: dict[str, str]) -> list[str]:
    """Return the topics with clouds that the localizer can use; ``topics`` maps to types."""
    clouds = [topic for topic, msgtype in topics.items() if msgtype == POINT_CLOUD]
    # KISS-ICP's frame is deskewed and stamped like the raw cloud, so it can replace it. Its
    # keypoints and local map are not scans.
    raw = [topic for topic in clouds if not is_registered(topic)]
    return raw or [topic for topic in clouds if topic.endswith(KISS_FRAME)]
