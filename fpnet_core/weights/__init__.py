# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The packaged checkpoint and its manifest, read by :func:`fpnet_core.io.weights.read_weights`."""
