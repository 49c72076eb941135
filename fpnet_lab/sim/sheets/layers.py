# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Layer naming conventions of vector drawings."""

from __future__ import annotations

from fpnet_lab.sim.sheets.artwork import Role

LAYERINGS: dict[str, dict[Role, str]] = {
    'national': {
        Role.WALL: 'A-WALL',
        Role.WALL_PATTERN: 'A-WALL-PATT',
        Role.DOOR: 'A-DOOR',
        Role.WINDOW: 'A-GLAZ',
        Role.STAIRS: 'A-FLOR-STRS',
        Role.FURNITURE: 'A-FURN',
        Role.FILL: 'A-AREA-PATT',
        Role.TEXT: 'A-ANNO-TEXT',
        Role.DIMENSION: 'A-ANNO-DIMS',
        Role.AXIS: 'S-GRID',
        Role.SITE: 'L-SITE',
        Role.SHEET: 'A-ANNO-TTLB',
    },
    'german': {
        Role.WALL: 'Wand',
        Role.WALL_PATTERN: 'Wand_Schraffur',
        Role.DOOR: 'Tür',
        Role.WINDOW: 'Fenster',
        Role.STAIRS: 'Treppe',
        Role.FURNITURE: 'Möbel',
        Role.FILL: 'Fläche',
        Role.TEXT: 'Text',
        Role.DIMENSION: 'Bemaßung',
        Role.AXIS: 'Achsen',
        Role.SITE: 'Gelände',
        Role.SHEET: 'Plankopf',
    },
    'plain': {
        Role.WALL: 'Walls',
        Role.WALL_PATTERN: 'Hatch',
        Role.DOOR: 'Doors',
        Role.WINDOW: 'Windows',
        Role.STAIRS: 'Stairs',
        Role.FURNITURE: 'Furniture',
        Role.FILL: 'Areas',
        Role.TEXT: 'Text',
        Role.DIMENSION: 'Dimensions',
        Role.AXIS: 'Axes',
        Role.SITE: 'Site',
        Role.SHEET: 'Sheet',
    },
    'numbered': {
        Role.WALL: '010_WALLS',
        Role.WALL_PATTERN: '011_POCHE',
        Role.DOOR: '020_DOORS',
        Role.WINDOW: '030_WINDOWS',
        Role.STAIRS: '040_STAIRS',
        Role.FURNITURE: '500_FURNITURE',
        Role.FILL: '600_ZONES',
        Role.TEXT: '700_TEXT',
        Role.DIMENSION: '710_DIM',
        Role.AXIS: '800_AXES',
        Role.SITE: '900_SITE',
        Role.SHEET: '999_FRAME',
    },
    'none': dict.fromkeys(Role, '0'),
}
"""Layer names by role of a mark; ``none`` puts everything on one layer."""

SHARES = {'national': 0.35, 'german': 0.25, 'plain': 0.2, 'numbered': 0.1, 'none': 0.1}
"""Shares of drawings by layering. Chosen."""
