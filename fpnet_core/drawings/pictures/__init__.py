# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parsing of sheet images: walls, rooms and parser warnings."""
