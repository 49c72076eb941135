# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What makes data, weights and figures; no robot runs any of it, and the core never imports it."""
