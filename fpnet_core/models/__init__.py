# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Neural networks for region matching, each in one file: ``joint_attention`` and ``paper``.

They are written once for arrays and tensors: inference uses arrays, training uses tensors.
"""
