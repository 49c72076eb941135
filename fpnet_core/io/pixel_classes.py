# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a pixel of a drawing may show; the network that reads walls tells these apart."""

OUTSIDE = 0
"""Given: paper: frame, title block, legend, dimensions, the ground around the building."""

FLOOR = 1
WALL = 2
DOOR = 3
"""Given: the opening; its leaf and arc stand on the floor."""

WINDOW = 4  # given

CLASSES = ('outside', 'floor', 'wall', 'door', 'window')
