# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Roles of layers by their names.

The words come from the AIA, ISO 13567 and BS 1192 layer standards and from offices that name
layers in their own language.
"""

from __future__ import annotations

from enum import StrEnum
import re
import unicodedata


class LayerRole(StrEnum):
    """Content of a layer."""

    WALL = 'wall'
    WINDOW = 'window'
    DOOR = 'door'
    OTHER = 'other'  # furniture, texts, dimensions, axes, frames, ...
    UNKNOWN = 'unknown'


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


_NOTES = _words(
    'text texte texto testo anno annotation annotations dim dims dimension dimensions cota cotas '
    'cote cotes cotation quote bemassung mass masse mase tag tags iden ident note notes label '
    'labels beschriftung title titl legend legende schriftfeld defpoints viewport viewports vport '
    'revcloud revision symb symbol symbols frame border rahmen rand cadre'
)
_DOORS = _words(
    'door doors tuer tur tueren turen porte portes puerta puertas porta portas porte deur deuren '
    'drzwi dor dorr dorrar ovi ovet kapi dveri usa usi doorswing'
)
_WINDOWS = _words(
    'window windows wind glaz glazing glass fenster fenetre fenetres ventana ventanas janela '
    'janelas finestra finestre raam ramen kozijn okno okna vindu vindue fonster ikkuna pencere '
    'curtain curtainwall vitrage vidrio vitre fassade facade ventanal'
)
_WALLS = _words(
    'wall walls wand waende wande mauer mauern mur murs muro muros muri pared paredes parede '
    'tabique tabiques tabiqueria cloison cloisons partition partitions alvenaria vegg vegger vagg '
    'vaggar seina seinat sciana sciany stena steny duvar perete pereti drywall masonry brick '
    'mauerwerk beton concrete col cols column columns pillar pillars pilar pilares stutze stuetze '
    'stutzen poteau poteaux colonna colonne kolom shearwall murature muratura gips gipskarton '
    'trockenbau tragend'
)
_FURNITURE = _words(
    'furn furniture furnishing mobel moebel mobiliar mobilier mobiliario mobili mueble muebles '
    'meubel mebel casework cabinet cabinets desk desks chair chairs table tables seat seating bed '
    'beds sofa fixt fixture fixtures sanit sanitary sanitaer sanitar plumb plumbing wc toilet '
    'toilets bath kitchen kuche kueche cuisine cocina appl appliance equip eqpm equipment '
    'ausstattung plant plants planting tree trees veg vegetation landscape car cars parking '
    'people person electr electrical elektro light lights lite lighting power hvac mech duct '
    'pipe pipes heating fire sprinkler handrail railing rail hrail north nord compass logo hatch '
    'hatches patt pattern schraffur sombreado rayure tile tiles'
)
_OTHERS = _words(
    'grid grids axis axes axe achse achsen raster eje ejes scale site contour contours topo '
    'survey property clng ceiling decke roof dach stair stairs strs treppe treppen escalier '
    'escaliers escalera escaleras scala trap lift lifts elevator ascensor aufzug elev flooring '
    'hidden dashed cloud image images xref ref reference construction pavement carpet section '
    'sections cut'
)
_STEMS = (  # stems of compound or inflected words, and of languages without spaces
    (LayerRole.DOOR, ('tuer', 'door', 'двер', '门', '門', 'ドア', '문')),
    (LayerRole.WINDOW, ('fenster', 'window', 'окн', '窗', '窓', '창')),
    (LayerRole.WALL, ('wand', 'waende', 'wande', 'wall', 'mauer', 'стен', 'колонн', '墙', '牆',
                      '壁', '柱', '벽')),
    (LayerRole.OTHER, ('mobel', 'moebel', 'furni', 'мебель', '家具', 'text', 'bemass', 'treppe')),
)  # fmt: skip
_WORDS = (
    (LayerRole.OTHER, _NOTES),
    (LayerRole.DOOR, _DOORS),
    (LayerRole.WINDOW, _WINDOWS),
    (LayerRole.WALL, _WALLS),
    (LayerRole.OTHER, _FURNITURE | _OTHERS),
)
_CAMEL = re.compile(r'(?<=[a-zà-ÿ])(?=[A-Z])')
_LETTERS = re.compile(r'[^\W\d_]+')


def layer_role(name: str) -> LayerRole:
    """
    Return the role of a layer, block or group by its name; ``UNKNOWN`` if not recognized.

    Words for floors, rooms, areas and fills are ignored, as walls may be on such layers.
    """
    words = _words_of(name)
    for role, known in _WORDS:
        if words & known:
            return role
    for role, stems in _STEMS:
        if any(stem in word for word in words for stem in stems):
            return role
    return LayerRole.UNKNOWN


def is_symbols(name: str) -> bool:
    """Return whether a name means furniture, hatches, texts, titles or frames: never walls."""
    words = _words_of(name)
    return bool(words & (_NOTES | _FURNITURE)) or any(
        stem in word for role, stems in _STEMS if role is LayerRole.OTHER
        for word in words for stem in stems
    )  # fmt: skip


def _words_of(name: str) -> set[str]:
    """Return the words of a name in lower case without accents, plurals also in the singular."""
    words = {_plain(word) for word in _LETTERS.findall(_CAMEL.sub(' ', name))}
    return words | {word[:-1] for word in words if word.endswith('s') and len(word) > 4}


def _plain(word: str) -> str:
    """Return a word in lower case without accents."""
    spread = unicodedata.normalize('NFKD', word.casefold())
    return unicodedata.normalize('NFC', ''.join(c for c in spread if not unicodedata.combining(c)))
