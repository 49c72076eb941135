# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rasters of storeys: drawing styles, symbols, distortions, and imitated robot maps."""
