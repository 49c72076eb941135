# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What files of each format hold: pictures, and vector drawings in a process with limits."""
