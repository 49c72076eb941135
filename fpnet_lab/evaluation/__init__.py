# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Predict, score, report: what a run or a matcher was worth, against ground truth."""
