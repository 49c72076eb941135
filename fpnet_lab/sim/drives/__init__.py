# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulated robot tours: routes, driving, odometry, sweeps and recordings."""
