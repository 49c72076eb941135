# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trainable parameters of the matching networks; the computation is in ``fpnet_core.models``."""
