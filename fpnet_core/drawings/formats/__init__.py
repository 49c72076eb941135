# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Readers of drawing formats: images, and vector drawings in a limited subprocess."""
