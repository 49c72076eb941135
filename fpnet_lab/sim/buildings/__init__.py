# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Buildings that can be ray-cast: raised from layouts, with doors and windows, furnished."""
