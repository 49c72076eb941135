# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Benchmarks of multi-storey sites, outdated drawings and plan libraries."""
