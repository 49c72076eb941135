# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Plots of maps, matches and runs; the functions that draw import matplotlib."""
