# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Submaps: registered scans as a raster of free space, walls and lintels."""

from fpnet_core.submaps.builder import SubmapBuilder
from fpnet_core.submaps.cloud import submap_from_cloud
from fpnet_core.submaps.image import submap_from_grid

__all__ = ['SubmapBuilder', 'submap_from_cloud', 'submap_from_grid']
