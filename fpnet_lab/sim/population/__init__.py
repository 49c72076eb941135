# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Generated storeys beside real, hand-labelled ones: what they have in common."""
