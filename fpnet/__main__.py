# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Run the command line as ``python -m fpnet``."""

from fpnet.cli import main

main()
