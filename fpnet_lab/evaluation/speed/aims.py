# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Aims for a large storey, in a module of its own that pages can import cheaply."""

# Given: aims on a storey of 20,000 m2, for a searching update (wall time) and for peak memory.
AIM_M2, AIM_TICK_S, AIM_PEAK_BYTES = 20_000, 0.5, 1.5e9
