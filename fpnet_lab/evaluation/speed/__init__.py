# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Durations of all operations that a user or a robot waits for, with their aims."""
