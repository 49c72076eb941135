# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parser of building drawings: from any drawing to a map, with a record of the parse."""
