# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of topics with a fixed meaning."""

import re

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
