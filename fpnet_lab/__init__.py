# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Data generation, training and evaluation; neither robots nor the core import this package."""
