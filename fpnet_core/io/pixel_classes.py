# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Classes of pixels in a drawing, as labelled by the wall segmentation network."""

OUTSIDE = 0
"""Given: frame, title block, legend, dimensions and the ground around the building."""

FLOOR = 1
WALL = 2
DOOR = 3
"""Given: the opening only; the door leaf and its arc are floor."""

WINDOW = 4  # given

CLASSES = ('outside', 'floor', 'wall', 'door', 'window')
