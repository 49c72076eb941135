# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Realistic sheets: drawn, coloured, lettered and scanned storeys, with ground truth."""

from fpnet_lab.sim.sheets.looks import STANDARD_KINDS, SheetKind
from fpnet_lab.sim.sheets.sheet import Sheet, draw_sheet

__all__ = ['STANDARD_KINDS', 'Sheet', 'SheetKind', 'draw_sheet']
