# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Buildings for ray casting: extruded from layouts, with doors, windows and furniture."""
