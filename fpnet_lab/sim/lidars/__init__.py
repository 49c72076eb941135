# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lidar models, their sweeps, and finished point clouds of buildings."""
