# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""File input and output of maps, point clouds, recordings and trajectories."""
