# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The files that a session of the nodes leaves in its folder: written there, read by the lab."""

from __future__ import annotations

POSES_NAME, SESSION_NAME = 'poses.tum', 'session.json'
"""Every published pose; what was said after each tick, and counts of scans."""

TICK_NAME, TICKS_NAME = 'last_tick.npz', 'ticks'
"""The last tick, and the folder of all ticks: of ``fpnet_core.io.runs`` each."""
