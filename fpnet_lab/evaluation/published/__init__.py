# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What pages of the documentation show of reports: tables between markers, by their makers."""
