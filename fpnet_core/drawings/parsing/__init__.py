# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One parser for pictures of floorplans: walls, doors, windows, rooms, outside and scale."""
