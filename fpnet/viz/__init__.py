# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pictures of maps, matches and runs; matplotlib is loaded by the functions that draw."""
