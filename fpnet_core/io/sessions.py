# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Names of the files that the nodes write in a session folder and that fpnet_lab reads."""

from __future__ import annotations

POSES_NAME, SESSION_NAME = 'poses.tum', 'session.json'
"""All published poses; the status after each update, and counts of scans."""

TICK_NAME, TICKS_NAME = 'last_tick.npz', 'ticks'
"""The last update, and the folder of all updates, in the format of ``fpnet_core.io.runs``."""
