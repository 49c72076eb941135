# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Damaged input files for every reader; benchmarks/fuzz_readers.py and a test share this."""
