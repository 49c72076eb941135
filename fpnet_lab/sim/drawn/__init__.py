# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Storeys as rasters: in every style, with symbols, distorted, and as robots map them."""
