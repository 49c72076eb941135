# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Localization benchmark: recordings on plans with real odometry, and baselines."""
