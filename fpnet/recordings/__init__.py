# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Recordings on disk: bags, CARMEN logs and folders of scans, with trajectories and truth."""
