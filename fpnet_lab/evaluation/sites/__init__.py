# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sites of several storeys, drawings that are out of date, libraries of plans."""
