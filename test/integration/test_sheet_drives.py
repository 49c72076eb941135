# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A robot is found on its building's own sheets, of every kind and file format."""

import pytest

from fpnet_core.config import FpnetConfig
from fpnet_lab.evaluation.sheet_drives import SHEETS, drives_on_sheets

pytestmark = pytest.mark.slow
SEED = 3


def test_a_robot_is_found_on_its_sheets_of_unknown_scale(tmp_path):
    drives = drives_on_sheets(SEED, tmp_path, FpnetConfig())
    print(*drives, sep='\n')
    written = {path.suffix for path in tmp_path.iterdir()}
    assert written == {'.png', '.jpg', '.pdf', '.svg', '.dxf'}
    assert len(drives) == 1 + len(SHEETS)
    for drive in drives:
        assert drive.found_after_m is not None, drive
        assert drive.error_m < 0.3, drive
