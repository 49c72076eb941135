# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The localization benchmark: recordings on plans, through real odometry, with baselines."""
