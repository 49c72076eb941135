# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of topics that mean the same in every recording and on every robot."""

import re

TF_TOPIC, TF_STATIC_TOPIC, CLOCK_TOPIC = '/tf', '/tf_static', '/clock'
"""Given: of tf2, and of simulated time."""

KISS_FRAME, KISS_ODOMETRY = 'kiss/frame', 'kiss/odometry'
"""Given: what KISS-ICP's own node publishes, in its namespace."""

TRUTH_TOPICS = re.compile(r'truth|(^|[/_])gt([/_]|$)', re.IGNORECASE)
"""Topics with true poses, which are no odometry."""

_REGISTERED = re.compile(r'(^|/)kiss/(frame|keypoints|local_map)$')


def is_registered(topic: str) -> bool:
    """
    Tell whether KISS-ICP publishes the clouds on a topic.

    They are without the motion during their sweeps and without times, their stamps their poses'.
    """
    return _REGISTERED.search(topic) is not None
