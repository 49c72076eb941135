# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Buildings and their storeys: what is read of them, and which of them look alike."""

from fpnet_core.sites.site import Link, LinkKind, NamedDoor, Site, Storey

__all__ = ['Link', 'LinkKind', 'NamedDoor', 'Site', 'Storey']
