# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Open benchmark: cases on disk, any program as a participant, and its scores."""
