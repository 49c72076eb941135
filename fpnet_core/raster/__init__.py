# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
What every stage does with rasters, once: blocks, distances, shapes, rays, windows, pixels, warps.

Rasters are indexed [row, column], ``(H, W)``; lengths are in cells unless a name says ``_m``, and
fractional places (row, column) are whole numbers at cell centres. Of a :class:`GridMap` row 0 is
the lowest y; of a picture, the top. Each idea has its module; nothing is imported from here.
"""
