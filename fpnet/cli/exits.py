# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Exit statuses besides 0 and 1."""

NO_ANSWER = 3
"""Given: exit status of a run without errors and without an answer; users' scripts test it."""
