# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From the picture of a sheet to its walls and rooms, and whether that reading is right."""
