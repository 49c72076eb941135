# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Matching pairs: a drawing and a part of a robot map, with the true answer; made, kept, read."""
