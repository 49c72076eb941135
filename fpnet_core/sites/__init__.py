# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sites: buildings with several storeys, their files, and localization on them."""

from fpnet_core.sites.site import Link, LinkKind, NamedDoor, Site, Storey

__all__ = ['Link', 'LinkKind', 'NamedDoor', 'Site', 'Storey']
