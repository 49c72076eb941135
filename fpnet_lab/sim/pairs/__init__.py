# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Matching pairs of a drawing and a partial robot map with ground truth: generation, storage."""
