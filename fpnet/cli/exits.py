# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What commands exit with beside 0 and 1."""

NO_ANSWER = 3
"""Exit status of a run that went well and cannot say where; given, as users' scripts ask."""
