# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The networks.

``joint_attention`` is written once for arrays and tensors: robots run it on the former, training
on the latter. ``config``, ``batch``, ``arrays``, ``joint_attention`` and ``inference`` load no
torch; the others do.
"""
