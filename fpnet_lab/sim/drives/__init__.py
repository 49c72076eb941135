# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots on tours through buildings and meshes: routes, driving, odometry, sweeps, recordings."""
