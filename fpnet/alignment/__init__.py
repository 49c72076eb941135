# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Alignment of a robot map with a floorplan: transform, local deformation, residuals, exports."""

from fpnet.alignment.aligning import Alignment, align_match

__all__ = ['Alignment', 'align_match']
