# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Neural networks for region matching.

``joint_attention`` is written once for arrays and tensors: inference on robots uses arrays,
training uses tensors. ``config``, ``batch``, ``arrays``, ``joint_attention`` and ``inference`` do
not import torch; the others do.
"""
