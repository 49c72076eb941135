# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports of runs and floorplan checks, each one HTML file that needs no network."""

from fpnet.report.exports import write_run_exports
from fpnet.report.record import RunRecord
from fpnet.report.run_page import write_run_report

__all__ = ['RunRecord', 'write_run_exports', 'write_run_report']
