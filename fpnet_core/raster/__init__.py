# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Raster operations of all stages: blocks, distances, morphology, rays, windows, pixels, warps.

Rasters are indexed [row, column], ``(H, W)``. Lengths are in cells unless a name ends in ``_m``;
fractional places (row, column) are integers at cell centres. Row 0 of a :class:`GridMap` is at the
lowest y, of a picture at the top. Import from the submodules; this module exports nothing.
"""
