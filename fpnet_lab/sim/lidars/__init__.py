# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Lidars by name, their sweeps, and finished clouds of buildings."""
