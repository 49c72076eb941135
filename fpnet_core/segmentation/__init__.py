# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Segmentation of grids into rooms and doors."""

from fpnet_core.segmentation.floorplan import segment_floorplan
from fpnet_core.segmentation.incremental import SubmapSegmenter
from fpnet_core.segmentation.scale import (
    STATED_SCALE,
    ScaleEstimate,
    estimate_metres_per_unit,
    segment_unknown_scale,
    told_scale,
)
from fpnet_core.segmentation.submap import segment_submap

__all__ = [
    'STATED_SCALE',
    'ScaleEstimate',
    'SubmapSegmenter',
    'estimate_metres_per_unit',
    'segment_floorplan',
    'segment_submap',
    'segment_unknown_scale',
    'told_scale',
]
