# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What names of layers say."""

import pytest

from fpnet_core.drawings.formats.layers import layer_role


@pytest.mark.parametrize(
    ('role', 'names'),
    [
        ('wall', ('A-WALL', 'A-WALL-EXT', 'WAND', 'Außenwand', 'Innenwände', 'TrennWand', 'MUR',
                     'murs porteurs', 'PARED', '01_MUROS', 'S-COLS', '墙', '墙体', 'СТЕНЫ', '벽체',
                     'Mauerwerk', 'ARCH$Walls', 'Cloisons', 'tabiques', 'Vägg', 'interiorWalls',
                     'A-WALL-PATT', 'ściana')),
        ('door', ('A-DOOR', 'Türen', 'Tür', 'Innentuer', 'PORTES', 'Puertas', '门', 'ДВЕРИ')),
        ('window', ('A-GLAZ', 'Fenster', 'FENÊTRES', 'ventanas', '窗', 'Curtain wall')),
        ('other', ('A-FURN', 'Möbel', 'MOBILIER', 'A-ANNO-TEXT', 'A-WALL-IDEN', 'Bemaßung',
                      'COTES', 'Defpoints', 'A-FLOR-STRS', 'S-GRID', '家具', 'Treppen', 'Rahmen')),
        ('unknown', ('0', '', 'Layer 1', 'E15-344', 'a', 'Ebene 7', 'GROUND')),
    ],
)  # fmt: skip
def test_names(role, names):
    assert {name: layer_role(name) for name in names} == dict.fromkeys(names, role)
