# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Diagnosis of a recording or of live topics, including checks that register the scans."""
